//! NUCLEO-G474RE: 512 KiB of flash in two banks, a crystal of 24 MHz.

use embassy_stm32::pac;
use embassy_stm32::rcc::{Hse, HseMode, PllPreDiv};
use embassy_stm32::time::mhz;

use super::chip::clocks_of_170_mhz;
pub(super) use super::random::random;

/// As in its user manual (UM2505).
pub const NAME: &str = "NUCLEO-G474RE";

/// The core's clock \[Hz\].
pub const CORE_HZ: u32 = 170_000_000;

/// 170 MHz from the crystal.
pub fn clocks() -> embassy_stm32::Config {
    clocks_of_170_mhz(Hse { freq: mhz(24), mode: HseMode::Oscillator }, PllPreDiv::DIV6)
}

/// The drivers' enable pin, PB10.
#[inline(always)]
pub(super) fn set_enable_pin(high: bool) {
    pac::GPIOB.bsrr().write(|w| if high { w.set_bs(10, true) } else { w.set_br(10, true) });
}
