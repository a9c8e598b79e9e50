//! What must hold before a motor may move: the watchdog before the clocks, the flash accelerator, the
//! brown-out level, the clock security system, and what a debugger's halt does.
//!
//! Sections are those of RM0090; RM0390 (F446) and RM0383 (F411) have the same registers.
//!
//! | what | why | section |
//! | --- | --- | --- |
//! | watchdog before the clocks | a crystal that does not start must not hang the chip unguarded | 21.3 |
//! | TIM1 stops with the core | otherwise a debugger's halt leaves the last duty on the motors | 38.16.5, 17.3.21 |
//! | prefetch and both caches | at five wait states the core waits for most of its instructions otherwise | 3.5.2 |
//! | brown-out level 3 | below 2.7 V flash and core are out of range at this clock | 3.9.10, 6.1.2 |
//! | clock security system | a crystal that stops ends in an interrupt and stops TIM1's outputs | 6.2.7 |

use embassy_stm32::interrupt::{self, Interrupt, InterruptExt};
use embassy_stm32::pac::{self, FLASH, RCC};
use embassy_stm32::{Config, Peripherals};

use shared_proto::ResetCause;

use super::guard;
use super::tasks::SERVICE_PRIORITY;

/// `BOR_LEV` of the option bytes: level 3, which resets the chip below 2.7 to 2.9 V.
const BROWN_OUT_LEVEL: u8 = 0b00;

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
    guard::start_watchdog();
    super::reset::guard_stack();
    pac::DBGMCU.apb2fzr().modify(|w| w.set_tim1(true));
    set_brown_out_level();
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
    // Caches are reset while they are off: they are, after a reset of the chip.
    FLASH.acr().modify(|w| {
        w.set_icrst(true);
        w.set_dcrst(true);
    });
    FLASH.acr().modify(|w| {
        w.set_icrst(false);
        w.set_dcrst(false);
        w.set_prften(true);
        w.set_icen(true);
        w.set_dcen(true);
    });
}

/// Writes the option bytes, once in a chip's life: afterwards they have the level already.
fn set_brown_out_level() {
    if FLASH.optcr().read().bor_lev() == BROWN_OUT_LEVEL {
        return;
    }
    // The core may stand still as long as for the erasure of a sector.
    guard::stretch();
    FLASH.optkeyr().write_value(0x0819_2A3B);
    FLASH.optkeyr().write_value(0x4C5D_6E7F);
    while FLASH.sr().read().bsy() {}
    FLASH.optcr().modify(|w| w.set_bor_lev(BROWN_OUT_LEVEL));
    FLASH.optcr().modify(|w| w.set_optstrt(true));
    while FLASH.sr().read().bsy() {}
    FLASH.optcr().modify(|w| w.set_optlock(true));
    guard::unstretch();
}
