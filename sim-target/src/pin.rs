//! An active-low input of the simulated board.

use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use core::future::poll_fn;
use core::task::{Poll, Waker};
use std::rc::Rc;

use embedded_hal::digital::ErrorType;
use embedded_hal_async::digital::Wait;

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

    async fn wait_for(&self, mut ready: impl FnMut(bool) -> bool) {
        poll_fn(|context| {
            if ready(self.0.low.get()) {
                return Poll::Ready(());
            }
            *self.0.waker.borrow_mut() = Some(context.waker().clone());
            Poll::Pending
        })
        .await;
    }
}

impl ErrorType for Pin {
    type Error = Infallible;
}

impl Wait for Pin {
    async fn wait_for_high(&mut self) -> Result<(), Infallible> {
        self.wait_for(|low| !low).await;
        Ok(())
    }

    async fn wait_for_low(&mut self) -> Result<(), Infallible> {
        self.wait_for(|low| low).await;
        Ok(())
    }

    async fn wait_for_rising_edge(&mut self) -> Result<(), Infallible> {
        self.wait_for_low().await?;
        self.wait_for_high().await
    }

    async fn wait_for_falling_edge(&mut self) -> Result<(), Infallible> {
        self.wait_for_high().await?;
        self.wait_for_low().await
    }

    async fn wait_for_any_edge(&mut self) -> Result<(), Infallible> {
        let before = self.0.low.get();
        self.wait_for(|low| low != before).await;
        Ok(())
    }
}
