//! The control tick: a timer of its own, in whose interrupt the control tasks run.
//!
//! TIM2 counts microseconds and interrupts at every control period. The handler wakes the capture task and
//! runs the control tasks' executor there and then: neither embassy's clock with its queue of timers nor
//! a second interrupt lies between the timer and the encoders.

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

/// A tick is due and not yet answered.
static DUE: AtomicBool = AtomicBool::new(false);

/// The capture task.
static WAITS: AtomicWaker = AtomicWaker::new();

/// The executor of the control tasks. It runs in this timer's interrupt.
pub(super) static CONTROL: InterruptExecutor = InterruptExecutor::new();

/// TIM2.
pub struct Tim2ControlTimer {
    timer: Timer<'static, TIM2>,
    counts: bool,
}

impl Tim2ControlTimer {
    /// Sets the timer up; it begins to count when the capture task first waits for it.
    pub fn new(timer: Peri<'static, TIM2>) -> Self {
        let timer = Timer::new(timer);
        let microseconds = timer.get_clock_frequency().0 / 1_000_000;
        pac::TIM2.psc().write_value((microseconds - 1) as u16);
        pac::TIM2.arr().write_value(CONTROL_PERIOD_US - 1);
        // Takes the two over, and is no tick.
        pac::TIM2.egr().write(|w| w.set_ug(true));
        timer.clear_update_interrupt();
        timer.enable_update_interrupt(true);
        Self { timer, counts: false }
    }
}

impl ControlTimer for Tim2ControlTimer {
    async fn next(&mut self) {
        if !self.counts {
            self.counts = true;
            self.timer.start();
        }
        poll_fn(|context| {
            if DUE.swap(false, Ordering::Relaxed) {
                Poll::Ready(())
            } else {
                WAITS.register(context.waker());
                Poll::Pending
            }
        })
        .await;
    }
}

/// To be called in TIM2's interrupt, and nowhere else.
///
/// # Safety
/// After [`super::tasks::spawn_control`].
#[inline(always)]
pub unsafe fn on_interrupt() {
    // The executor pends this interrupt too, for a task that another one woke.
    if pac::TIM2.sr().read().uif() {
        pac::TIM2.sr().write(|w| w.set_uif(false));
        DUE.store(true, Ordering::Relaxed);
        WAITS.wake();
    }
    // SAFETY: the caller's.
    unsafe { CONTROL.on_interrupt() };
}
