//! The brown-out level in the option bytes.

use embassy_stm32::pac::FLASH;

use super::reset_cause::has_loaded_options;
use crate::board::guard;

/// `BOR_LEV`: level 4, which resets the chip below 2.76 to 2.86 V (DS12288, table 19). The chip itself would run down to
/// 1.71 V, but its converter measures the robot's supply against the 3.3 V.
const BROWN_OUT_LEVEL: u8 = 0b100;

/// Writes the option bytes, once in a chip's life, and restarts the chip, which loads them (3.4.2): afterwards they have the
/// level already. If they do not, this start does without it: a second restart would change nothing.
pub(in crate::board) fn set_brown_out_level() {
    if FLASH.optr().read().bor_lev() == BROWN_OUT_LEVEL || has_loaded_options() {
        return;
    }
    // The core may stand still as long as for the erasure of two pages.
    guard::stretch();
    while FLASH.sr().read().bsy() {}
    // The error flags are cleared by writing them back.
    FLASH.sr().modify(|_| {});
    FLASH.keyr().write_value(0x4567_0123);
    FLASH.keyr().write_value(0xCDEF_89AB);
    FLASH.optkeyr().write_value(0x0819_2A3B);
    FLASH.optkeyr().write_value(0x4C5D_6E7F);
    FLASH.optr().modify(|w| w.set_bor_lev(BROWN_OUT_LEVEL));
    FLASH.cr().modify(|w| w.set_optstrt(true));
    while FLASH.sr().read().bsy() {}
    FLASH.cr().modify(|w| w.set_obl_launch(true));
    // Not reached, unless the flash has refused.
    FLASH.cr().modify(|w| w.set_lock(true));
    guard::unstretch();
}
