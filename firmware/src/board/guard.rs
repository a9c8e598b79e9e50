//! The guard: an interrupt above all tasks. It feeds the watchdog while every task meets its deadline,
//! and switches the motors off when one misses it. They check in at [`super::check_in`].
//!
//! ```text
//! part      checks in                        deadline
//! capture   when the encoders are read       20 ms
//! pid       when the motors are written      20 ms    (profile stands between the two)
//! others    all safety tasks have            40 ms
//!                                      then: motors off, the watchdog is not fed again
//! watchdog  31 ms nominal, 21 to 59 ms over its oscillator's range (17 to 47 kHz; a G4's is narrower)
//! ```
//!
//! So when a part hangs, the motors are off within 50 ms (40 ms and one check) and the board restarts within 100 ms. Code that
//! hangs with interrupts masked stops the guard too: then the restart itself switches the motors off, at
//! most 59 ms after the last feed. A hard fault switches the motors off at once, like a panic.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::exception;
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::pac;
use embassy_stm32::pac::iwdg::vals::{Key, Pr};

use super::check_in::{self, PARTS};

/// How often the guard checks the parts \[Hz\].
const CHECK_HZ: u32 = 100;

/// A timeout of the watchdog, which counts cycles of an oscillator of nominally 32 kHz.
struct Timeout {
    divider: Pr,
    reload: u16,
}

/// 31 ms: 248 steps of 125 us.
const USUAL: Timeout = Timeout { divider: Pr::DIVIDE_BY4, reload: 247 };

/// 4 s: 4000 steps of 1 ms.
const STRETCHED: Timeout = Timeout { divider: Pr::DIVIDE_BY32, reload: 3999 };

/// Checks until every part must have checked in once: the store may need repair before it can be read.
const BOOT_CHECKS: u32 = 3 * CHECK_HZ;

/// Checks in a row that a part may miss, in the order of [`check_in::CheckedTask`].
const MISSES_MAX: [u32; PARTS] = [1, 1, 3];

/// How many checks in a row each part has missed.
static MISSED: [AtomicU32; PARTS] = [const { AtomicU32::new(0) }; PARTS];
/// Checks that are left for the start; 0 after it.
static BOOT: AtomicU32 = AtomicU32::new(BOOT_CHECKS);

/// Starts the watchdog. It needs no clock but its own.
pub(super) fn start_watchdog() {
    pac::IWDG.kr().write(|w| w.set_key(Key::START));
    set_watchdog(&USUAL);
}

/// Starts the guard's own timer.
pub fn start(mut systick: SYST) {
    // The clock's interrupt gets a lower priority than the guard's: the clock may hang as well.
    interrupt::TIM5.set_priority(Priority::P1);
    systick.set_clock_source(SystClkSource::Core);
    systick.set_reload(super::CORE_HZ / CHECK_HZ - 1);
    systick.clear_current();
    systick.enable_interrupt();
    systick.enable_counter();
}

/// Runs work that stops the core for up to two seconds, such as erasing the flash that the program runs
/// from. Only with the motors off.
pub async fn stretched<T>(work: impl Future<Output = T>) -> T {
    stretch();
    let result = work.await;
    unstretch();
    result
}

/// Gives the watchdog four seconds.
pub(super) fn stretch() {
    set_watchdog(&STRETCHED);
}

/// Gives the watchdog its usual timeout again.
pub(super) fn unstretch() {
    set_watchdog(&USUAL);
}

/// Gives the running watchdog another timeout.
fn set_watchdog(timeout: &Timeout) {
    let iwdg = pac::IWDG;
    iwdg.kr().write(|w| w.set_key(Key::ENABLE));
    iwdg.pr().write(|w| w.set_pr(timeout.divider));
    iwdg.rlr().write(|w| w.set_rl(timeout.reload));
    // Both cross into the oscillator's domain, which takes up to five of its cycles (RM0090, 21.4.4;
    // RM0440, 35.4.4). Fed
    // before that, the counter would restart from the old value, which may be shorter than an erasure.
    while iwdg.sr().read().0 != 0 {}
    feed();
}

fn feed() {
    pac::IWDG.kr().write(|w| w.set_key(Key::RESET));
}

#[exception]
fn SysTick() {
    let (mut all_alive, mut all_well) = (true, true);
    // Part by part: it may interrupt a control tick, and is to be short.
    for part in 0..PARTS {
        let alive = check_in::take(part);
        let missed = if alive { 0 } else { MISSED[part].load(Ordering::Relaxed).saturating_add(1) };
        MISSED[part].store(missed, Ordering::Relaxed);
        all_alive &= alive;
        all_well &= missed <= MISSES_MAX[part];
    }
    let boot = BOOT.load(Ordering::Relaxed);
    if boot > 0 {
        // The start is over when every part has checked in.
        BOOT.store(if all_alive { 0 } else { boot - 1 }, Ordering::Relaxed);
        feed();
    } else if all_well && !check_in::tripped() {
        feed();
    } else {
        check_in::trip();
        super::motors_off();
    }
}
