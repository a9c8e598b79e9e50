//! What must hold before a motor may move: the watchdog before the clocks, the flash accelerator, the
//! brown-out level, the clock security system, and what a debugger's halt does.
//!
//! What differs between the chips is in `f4` and `g4`.
//!
//! | what | why | RM0090 | RM0440 |
//! | --- | --- | --- | --- |
//! | watchdog before the clocks | a crystal that does not start must not hang the chip unguarded | 21.3 | 35.3 |
//! | TIM1 stops with the core | otherwise a debugger's halt leaves the last duty on the motors | 38.16.5, 17.3.21 | 47.16.2, 29.3.34 |
//! | prefetch and both caches | at four or five wait states the core waits for most of its instructions otherwise | 3.5.2 | 3.3.4 |
//! | brown-out level | below 2.7 V an F4's flash and core are out of range at this clock | 3.9.10, 6.1.2 | 3.4.1, 6.2 |
//! | clock security system | a crystal that stops ends in an interrupt and stops TIM1's outputs | 6.2.7 | 7.2.9 |

use embassy_stm32::interrupt::{self, Interrupt, InterruptExt};
use embassy_stm32::pac::{self, RCC};
use embassy_stm32::{Config, Peripherals};

use shared_proto::ResetCause;

use super::tasks::SERVICE_PRIORITY;
use super::{chip, guard};

/// What `main` calls first: the chip made safe, its clocks, its guard; and why the board started. `interrupts` are those
/// of the link.
pub fn start(interrupts: &[Interrupt]) -> (Peripherals, ResetCause) {
    let cause = super::reset::cause();
    begin();
    let peripherals = start_clocks(super::clocks());
    let core = cortex_m::Peripherals::take().expect("taken once");
    for interrupt in interrupts {
        interrupt.set_priority(SERVICE_PRIORITY);
    }
    guard::start(core.SYST);
    (peripherals, cause)
}

/// Starts the watchdog, then everything else that needs no clock.
fn begin() {
    chip::stop_with_core();
    guard::start_watchdog();
    super::reset::guard_stack();
    chip::set_brown_out_level();
}

/// Starts the clocks, and then what needs them.
fn start_clocks(clocks: Config) -> Peripherals {
    let peripherals = critical_section::with(|_| {
        let peripherals = embassy_stm32::init(clocks);
        // Embassy's clock counts half periods of its timer. The timer is reset with a compare value of 0, equal to
        // its counter, which sets the flag of the half period: counted, it would put the clock 65.5 ms ahead, and
        // have it read 65.5 ms less in any interrupt that comes before the next half period is counted.
        pac::TIM5.sr().write(|w| w.0 = 0);
        interrupt::TIM5.unpend();
        peripherals
    });
    finish();
    peripherals
}

/// What needs the clocks.
fn finish() {
    RCC.cr().modify(|w| w.set_csson(RCC.cr().read().hserdy()));
    chip::accelerate_flash();
}
