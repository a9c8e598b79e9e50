//! What an STM32G4 has of its own: flash, converter, clock tree, reset flags, option bytes, and what a debugger's halt
//! stops. The F4's is in `f4`, and in the files beside it.
//!
//! Sections are those of RM0440, revision 9; electrical figures are those of the data sheet DS12288, revision 6.
//!
//! | what | F4 | G4 |
//! | --- | --- | --- |
//! | flash | sectors of 16 KiB, words of 4 bytes | pages of 2 KiB, double words of 8 bytes with error correction |
//! | brown-out level | in force once it is written | in force after a reset that loads it |
//! | power-on and brown-out | two flags | one flag |
//! | the timers' clock | 84 to 168 MHz | 170 MHz |
//!
//! TIM1's break is the F4's in what the firmware uses of it. What is new stays at its reset value: the input is
//! connected to the timer (`TIM1_AF1.BKINE`), is an input only (`BDTR.BKBID`), armed (`BDTR.BKDSRM`, 29.3.19), and has no
//! filter, so that it needs no clock (29.3.18).

mod clocks;
pub mod flash;
mod option_bytes;
mod reset_cause;
pub mod supply;

use embassy_stm32::pac;

pub(super) use clocks::clocks_of_170_mhz;
pub(super) use flash::was_unreadable as was_unreadable_flash;
pub(super) use option_bytes::set_brown_out_level;
pub(super) use reset_cause::reset_cause;

/// A debugger's halt stops the watchdog, which must not reset such a core, and TIM1 with its outputs off (47.16.2,
/// 29.3.34).
pub(super) fn stop_with_core() {
    pac::DBGMCU.apb1lfzr().modify(|w| w.set_iwdg(true));
    pac::DBGMCU.apb2fzr().modify(|w| w.set_tim1(true));
}

/// Prefetch; both caches are on after a reset (3.3.4).
pub(super) fn accelerate_flash() {
    pac::FLASH.acr().modify(|w| w.set_prften(true));
}
