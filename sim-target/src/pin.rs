//! An active-low input of the simulated board.

use core::cell::{Cell, RefCell};
use core::future::poll_fn;
use core::task::{Poll, Waker};
use std::rc::Rc;

use firmware::hal::Level;

/// An input that the simulation pulls low.
#[derive(Clone, Default)]
pub(crate) struct Pin(Rc<PinState>);

#[derive(Default)]
struct PinState {
    low: Cell<bool>,
    waker: RefCell<Option<Waker>>,
}

impl Pin {
    pub(crate) fn set_low(&self, low: bool) {
        if self.0.low.replace(low) != low
            && let Some(waker) = self.0.waker.take()
        {
            waker.wake();
        }
    }

    /// Drops the waker: its task is about to be freed.
    pub(crate) fn forget_waiter(&self) {
        self.0.waker.take();
    }
}

impl Level for Pin {
    fn is_low(&self) -> bool {
        self.0.low.get()
    }

    async fn wait_until(&self, low: bool) {
        poll_fn(|context| {
            if self.is_low() == low {
                return Poll::Ready(());
            }
            *self.0.waker.borrow_mut() = Some(context.waker().clone());
            Poll::Pending
        })
        .await;
    }
}
