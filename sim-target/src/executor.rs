//! An embassy executor that can be shut down, so that one program simulates many robots.

use core::cell::{Cell, RefCell};
use core::future::{Future, poll_fn};
use core::pin::pin;
use core::task::{Poll, Waker};
use std::rc::Rc;

use embassy_executor::raw;

use crate::robot_task::{RobotTask, StoppedTasks};

/// Embassy calls this when a task becomes ready. `context` is the executor's `pending` flag.
#[unsafe(export_name = "__pender")]
fn pender(context: *mut ()) {
    // SAFETY: the context given to `raw::Executor::new` below is a `Cell<bool>` that lives as long
    // as its executor, and simulated tasks are only woken on the executor's own thread.
    let pending = unsafe { &*context.cast::<Cell<bool>>() };
    pending.set(true);
}

/// Runs tasks until all of them wait.
pub(crate) struct Executor {
    raw: *mut raw::Executor,
    pending: *mut Cell<bool>,
    /// Frees a task's storage. Called when its future has ended.
    storages: Vec<Box<dyn FnOnce()>>,
    ending: Rc<Ending>,
    stopped: StoppedTasks,
}

/// Asks every task to end.
#[derive(Default)]
struct Ending {
    now: Cell<bool>,
    wakers: RefCell<Vec<Waker>>,
}

impl Executor {
    /// An executor that leaves out the tasks that are stopped.
    pub(crate) fn new(stopped: StoppedTasks) -> Self {
        let pending = Box::into_raw(Box::new(Cell::new(false)));
        let raw = Box::into_raw(Box::new(raw::Executor::new(pending.cast())));
        Self { raw, pending, storages: Vec::new(), ending: Rc::default(), stopped }
    }

    fn raw(&self) -> &'static raw::Executor {
        // SAFETY: `raw` is valid until `drop`, which ends all tasks first and hands out nothing after.
        unsafe { &*self.raw }
    }

    /// Adds a task. It ends when the executor is dropped.
    pub(crate) fn spawn<F: Future + 'static>(&mut self, name: RobotTask, task: F) {
        let (ending, stopped) = (self.ending.clone(), self.stopped.clone());
        self.spawn_raw(async move {
            let mut task = pin!(task);
            let mut known = false;
            poll_fn(|context| {
                if ending.now.get() {
                    return Poll::Ready(());
                }
                if !known {
                    known = true;
                    ending.wakers.borrow_mut().push(context.waker().clone());
                }
                if stopped.contains(name) {
                    return Poll::Pending;
                }
                task.as_mut().poll(context).map(|_| ())
            })
            .await;
        });
    }

    fn spawn_raw<F: Future<Output = ()> + 'static>(&mut self, future: F) {
        let storage: *mut raw::TaskStorage<F> = Box::into_raw(Box::new(raw::TaskStorage::new()));
        // SAFETY: freed in `drop`, after the task in it has ended.
        let token = unsafe { &*storage }.spawn(move || future).expect("a new storage is free");
        self.raw().spawner().spawn(token);
        // SAFETY: made by `Box::into_raw` above, called once.
        self.storages.push(Box::new(move || drop(unsafe { Box::from_raw(storage) })));
    }

    /// Runs every task that is ready, until none is. Returns whether any was.
    pub(crate) fn poll(&mut self) -> bool {
        let mut any = false;
        // SAFETY: as in `raw`.
        while unsafe { &*self.pending }.replace(false) {
            any = true;
            // SAFETY: on the executor's thread, and not from within one of its tasks: `&mut self`.
            unsafe { self.raw().poll() };
        }
        any
    }
}

impl Drop for Executor {
    fn drop(&mut self) {
        self.ending.now.set(true);
        for waker in self.ending.wakers.take() {
            waker.wake();
        }
        self.poll();
        for free in self.storages.drain(..) {
            free();
        }
        // SAFETY: made by `Box::into_raw` in `new`; no task is left that could use them.
        unsafe {
            drop(Box::from_raw(self.raw));
            drop(Box::from_raw(self.pending));
        }
    }
}
