//! What an STM32F4 has of its own for the start: why it was reset, its flash accelerator, its brown-out level, and what a
//! debugger's halt stops. The G4's is in `g4`.
//!
//! Sections are those of RM0090; RM0390 (F446) and RM0383 (F411) have the same registers.

use embassy_stm32::pac::{self, FLASH};
use shared_proto::ResetCause;

use super::guard;

/// `BOR_LEV` of the option bytes: level 3, which resets the chip below 2.7 to 2.9 V.
const BROWN_OUT_LEVEL: u8 = 0b00;

/// A debugger's halt stops the watchdog, which must not reset such a core, and TIM1 with its outputs off (38.16.4,
/// 38.16.5).
pub(super) fn stop_with_core() {
    pac::DBGMCU.apb1fzr().modify(|w| w.set_iwdg(true));
    pac::DBGMCU.apb2fzr().modify(|w| w.set_tim1(true));
}

/// Why the chip was reset, if not by a panic. Clears the cause (6.3.21).
pub(super) fn reset_cause(panicked: bool) -> ResetCause {
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    // Power-on also sets the pin and brown-out flags, and every reset sets the pin flag.
    if flags.porrstf() {
        ResetCause::PowerOn
    } else if panicked {
        ResetCause::Panic
    } else if flags.wdgrstf() || flags.wwdgrstf() {
        ResetCause::Watchdog
    } else if flags.sftrstf() {
        ResetCause::Software
    } else if flags.borrstf() {
        ResetCause::BrownOut
    } else {
        ResetCause::Pin
    }
}

/// Prefetch and both caches (3.5.2).
pub(super) fn accelerate_flash() {
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

/// Writes the option bytes, once in a chip's life: afterwards they have the level already (3.9.10).
pub(super) fn set_brown_out_level() {
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

/// This chip's only interrupt that cannot be masked comes from its clock.
pub(super) fn was_unreadable_flash() -> bool {
    false
}
