//! The control timer: the control tasks run in its interrupt.
//!
//! TIM2 counts microseconds and interrupts at every control period. The handler wakes the capture task and
//! runs the control tasks' executor at once. Neither embassy's clock nor a second interrupt delays the
//! reading of the encoders.

use core::future::poll_fn;
use core::sync::atomic::{AtomicBool, Ordering};
use core::task::Poll;

use embassy_executor::InterruptExecutor;
use embassy_stm32::Peri;
use embassy_stm32::pac;
use embassy_stm32::peripherals::TIM2;
use embassy_stm32::timer::low_level::Timer;
use embassy_sync::waitqueue::AtomicWaker;

use crate::hal::ControlTimer;
use crate::units::CONTROL_PERIOD_US;

/// A tick is due and capture has not taken it yet.
static DUE: AtomicBool = AtomicBool::new(false);

/// Wakes the capture task.
static WAKER: AtomicWaker = AtomicWaker::new();

/// The executor of the control tasks. It runs in this timer's interrupt.
pub(super) static CONTROL: InterruptExecutor = InterruptExecutor::new();

/// TIM2.
pub struct Tim2ControlTimer {
    timer: Timer<'static, TIM2>,
    started: bool,
}

impl Tim2ControlTimer {
    /// Sets the timer up. Counting starts when the capture task first waits for a tick.
    pub fn new(timer: Peri<'static, TIM2>) -> Self {
        let timer = Timer::new(timer);
        let microseconds = timer.get_clock_frequency().0 / 1_000_000;
        pac::TIM2.psc().write_value((microseconds - 1) as u16);
        pac::TIM2.arr().write_value(CONTROL_PERIOD_US - 1);
        // Loads prescaler and period; the update event that this causes is no tick.
        pac::TIM2.egr().write(|w| w.set_ug(true));
        timer.clear_update_interrupt();
        timer.enable_update_interrupt(true);
        Self { timer, started: false }
    }
}

impl ControlTimer for Tim2ControlTimer {
    async fn next(&mut self) {
        if !self.started {
            self.started = true;
            self.timer.start();
        }
        poll_fn(|context| {
            if DUE.swap(false, Ordering::Relaxed) {
                Poll::Ready(())
            } else {
                WAKER.register(context.waker());
                Poll::Pending
            }
        })
        .await;
    }
}

/// Call this in TIM2's interrupt, and nowhere else.
///
/// # Safety
/// Call only after [`super::tasks::spawn_control`].
#[inline(always)]
pub unsafe fn on_interrupt() {
    // The executor also sets this interrupt pending when one task wakes another.
    if pac::TIM2.sr().read().uif() {
        pac::TIM2.sr().write(|w| w.set_uif(false));
        DUE.store(true, Ordering::Relaxed);
        WAKER.wake();
    }
    // SAFETY: the caller guarantees that the executor has been started.
    unsafe { CONTROL.on_interrupt() };
}
