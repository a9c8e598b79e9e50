//! The control timer: the control tasks run in its interrupt.
//!
//! TIM2 counts microseconds and interrupts at every control period. The handler polls capture, profile and PID
//! once each, in this order: each finds what the one before it left, so that a tick is one entry of the
//! interrupt, without an executor, wakers or a queue. Neither embassy's clock nor a second interrupt delays the
//! reading of the encoders.

use core::cell::UnsafeCell;
use core::future::poll_fn;
use core::pin::Pin;
use core::sync::atomic::{AtomicBool, Ordering};
use core::task::{Context, Poll, Waker};

use embassy_stm32::Peri;
use embassy_stm32::interrupt::{self, InterruptExt};
use embassy_stm32::pac;
use embassy_stm32::peripherals::TIM2;
use embassy_stm32::timer::low_level::Timer;

use crate::hal::ControlTimer;
use crate::units::CONTROL_PERIOD_US;

/// A tick is due and capture has not taken it yet.
static DUE: AtomicBool = AtomicBool::new(false);

/// What a tick is: one poll of the three control tasks.
type Tick = Pin<&'static mut dyn Future<Output = ()>>;

/// The tick, once [`run`] has handed it over.
struct TickCell(UnsafeCell<Option<Tick>>);

// SAFETY: `run` writes while the interrupt is off; afterwards only the interrupt touches it.
unsafe impl Sync for TickCell {}

static TICK: TickCell = TickCell(UnsafeCell::new(None));

/// TIM2, running.
pub struct Tim2ControlTimer {
    _timer: Timer<'static, TIM2>,
}

impl Tim2ControlTimer {
    /// Starts the timer. Its interrupt begins with [`run`].
    pub fn new(timer: Peri<'static, TIM2>) -> Self {
        let timer = Timer::new(timer);
        let microseconds = timer.get_clock_frequency().0 / 1_000_000;
        pac::TIM2.psc().write_value((microseconds - 1) as u16);
        pac::TIM2.arr().write_value(CONTROL_PERIOD_US - 1);
        // Loads prescaler and period; the update event that this causes is no tick.
        pac::TIM2.egr().write(|w| w.set_ug(true));
        timer.clear_update_interrupt();
        timer.enable_update_interrupt(true);
        timer.start();
        Self { _timer: timer }
    }
}

impl ControlTimer for Tim2ControlTimer {
    async fn next(&mut self) {
        // No waker: the interrupt polls whoever waits here.
        poll_fn(|_| {
            if DUE.load(Ordering::Relaxed) {
                DUE.store(false, Ordering::Relaxed);
                Poll::Ready(())
            } else {
                Poll::Pending
            }
        })
        .await;
    }
}

/// Polls `tick` in the timer's interrupt from now on.
///
/// # Safety
/// Call once. What `tick` points to must stay where it is, and nobody else may poll it, for ever.
pub(super) unsafe fn run(tick: Pin<&mut dyn Future<Output = ()>>) {
    // SAFETY: the caller guarantees that it lives for ever.
    let tick = unsafe { core::mem::transmute::<Pin<&mut dyn Future<Output = ()>>, Tick>(tick) };
    // SAFETY: the interrupt is still off.
    unsafe { *TICK.0.get() = Some(tick) };
    // SAFETY: the handler may run from here on; all that it uses is there.
    unsafe { interrupt::TIM2.enable() };
}

#[embassy_stm32::interrupt]
unsafe fn TIM2() {
    // SAFETY: this is the timer's interrupt.
    unsafe { on_interrupt() };
    // Writes must finish before the interrupt ends (Arm erratum 838869). The handler also ends here and not in
    // a tail call, so that the emulated board can count its instructions.
    cortex_m::asm::dsb();
}

/// # Safety
/// Not from anywhere but the interrupt, which it would interrupt itself.
#[inline(always)]
unsafe fn on_interrupt() {
    pac::TIM2.sr().write(|w| w.set_uif(false));
    DUE.store(true, Ordering::Relaxed);
    // SAFETY: only this interrupt uses the cell once it is enabled.
    if let Some(tick) = unsafe { &mut *TICK.0.get() } {
        let _ = tick.as_mut().poll(&mut Context::from_waker(Waker::noop()));
    }
}
