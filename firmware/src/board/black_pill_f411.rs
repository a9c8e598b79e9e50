//! WeAct Black Pill with an STM32F411CE: 512 KiB of flash in one bank, a crystal of 25 MHz.

use embassy_stm32::pac;
use embassy_stm32::rcc::{Hse, HseMode, PllPreDiv};
use embassy_stm32::time::mhz;

use super::clocks::clocks_of_96_mhz;
pub use super::one_bank::*;

/// As on the board.
pub const NAME: &str = "Black Pill F411";

/// The core's clock \[Hz\].
pub const CORE_HZ: u32 = 96_000_000;

/// 96 MHz from the crystal.
pub fn clocks() -> embassy_stm32::Config {
    clocks_of_96_mhz(Hse { freq: mhz(25), mode: HseMode::Oscillator }, PllPreDiv::DIV25)
}

/// The drivers' enable pin, PB10.
#[inline(always)]
pub(super) fn set_enable_pin(high: bool) {
    pac::GPIOB.bsrr().write(|w| if high { w.set_bs(10, true) } else { w.set_br(10, true) });
}
