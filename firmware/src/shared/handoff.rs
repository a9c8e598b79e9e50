//! How tasks hand things to each other: a notification, a mailbox, a shared cell.

use core::cell::{Cell, RefCell};
use core::pin::Pin;
use core::sync::atomic::{AtomicBool, Ordering, compiler_fence};
use core::task::{Context, Poll, Waker};

use embassy_sync::blocking_mutex::{Mutex, raw::RawMutex};
use embassy_sync::waitqueue::WakerRegistration;

use super::in_place::InPlace;

/// Wakes the one task that waits for it. Two notifications before that task runs count as one.
pub struct Notify<M: RawMutex> {
    pending: AtomicBool,
    /// A waker is registered.
    waiting: AtomicBool,
    waiter: Mutex<M, RefCell<WakerRegistration>>,
}

impl<M: RawMutex> Notify<M> {
    /// No notification is pending.
    pub const fn new() -> Self {
        Self {
            pending: AtomicBool::new(false),
            waiting: AtomicBool::new(false),
            waiter: Mutex::new(RefCell::new(WakerRegistration::new())),
        }
    }

    /// Wakes the waiting task, or lets its next wait end at once.
    #[inline(always)]
    pub fn notify(&self) {
        self.pending.store(true, Ordering::Relaxed);
        compiler_fence(Ordering::SeqCst);
        // A task that is polled at every tick, as control is on a board, leaves no waker.
        if self.waiting.load(Ordering::Relaxed) {
            self.wake();
        }
    }

    #[inline(never)]
    fn wake(&self) {
        // Waking removes the waker: a task that only polls now and then is not woken for nothing.
        self.waiter.lock(|waiter| {
            self.waiting.store(false, Ordering::Relaxed);
            waiter.borrow_mut().wake();
        });
    }

    #[inline(never)]
    fn register(&self, waker: &Waker) {
        self.waiter.lock(|waiter| {
            waiter.borrow_mut().register(waker);
            self.waiting.store(true, Ordering::Relaxed);
        });
        compiler_fence(Ordering::SeqCst);
    }

    /// Takes a pending notification; true if there was one.
    #[inline(always)]
    pub fn take(&self) -> bool {
        let pending = self.pending.load(Ordering::Relaxed);
        if pending {
            self.pending.store(false, Ordering::Relaxed);
        }
        pending
    }

    /// Waits for a notification.
    pub const fn wait(&self) -> impl Future<Output = ()> {
        Wait(self)
    }
}

/// Ends with the next notification.
struct Wait<'a, M: RawMutex>(&'a Notify<M>);

impl<M: RawMutex> Future for Wait<'_, M> {
    type Output = ();

    // By hand and not as an async block: a control tick polls six times.
    #[inline(always)]
    fn poll(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<()> {
        if self.0.take() {
            return Poll::Ready(());
        }
        // As `Waker::noop()` has it, of which there may be several.
        if context.waker().data().is_null() {
            return Poll::Pending;
        }
        self.0.register(context.waker());
        // A notification may have come in between, with no waker to wake.
        if self.0.take() { Poll::Ready(()) } else { Poll::Pending }
    }
}

impl<M: RawMutex> Default for Notify<M> {
    fn default() -> Self {
        Self::new()
    }
}

/// The latest value for the one task that waits for it.
///
/// Embassy's `Signal` does the same, but moves its whole value at every poll, even when there is none.
/// Here a poll that finds nothing costs one atomic load.
pub struct Mailbox<M: RawMutex, T> {
    arrived: Notify<M>,
    value: InPlace<M, Option<T>>,
}

impl<M: RawMutex, T> Mailbox<M, T> {
    /// An empty mailbox.
    pub const fn new() -> Self {
        Self { arrived: Notify::new(), value: InPlace::new(None) }
    }

    /// Puts a value in; one that nobody has taken yet is dropped.
    pub fn put(&self, value: T) {
        self.value.with(|slot| *slot = Some(value));
        self.arrived.notify();
    }

    /// Waits for a value and takes it.
    pub async fn next(&self) -> T {
        loop {
            self.arrived.wait().await;
            if let Some(value) = self.value.with(Option::take) {
                return value;
            }
        }
    }

    /// Takes the value, if there is one.
    pub fn try_take(&self) -> Option<T> {
        if self.arrived.take() { self.value.with(Option::take) } else { None }
    }

    /// Looks at the value where it lies, once, if there is one: a control tick has no time to copy a large one.
    #[inline(always)]
    pub(crate) fn if_new(&self, look: impl FnOnce(&T)) {
        if self.arrived.take() {
            self.value.with(|slot| slot.as_ref().map(look));
        }
    }
}

impl<M: RawMutex, T> Default for Mailbox<M, T> {
    fn default() -> Self {
        Self::new()
    }
}

/// A small value that several tasks read and write, always whole.
pub struct SharedCell<M: RawMutex, T>(Mutex<M, Cell<T>>);

impl<M: RawMutex, T: Copy> SharedCell<M, T> {
    /// A cell with its first value.
    pub const fn new(value: T) -> Self {
        Self(Mutex::new(Cell::new(value)))
    }

    /// Reads the value.
    pub fn get(&self) -> T {
        self.0.lock(Cell::get)
    }

    /// Replaces the value.
    pub fn set(&self, value: T) {
        self.0.lock(|cell| cell.set(value));
    }

    /// Changes the value; no other task sees an intermediate state.
    pub fn update(&self, change: impl FnOnce(&mut T)) {
        self.0.lock(|cell| {
            let mut value = cell.get();
            change(&mut value);
            cell.set(value);
        });
    }
}
