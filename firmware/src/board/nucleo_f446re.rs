//! NUCLEO-F446RE: 512 KiB of flash in one bank, 8 MHz from the ST-LINK.

use embassy_stm32::pac;

use super::clocks::clocks_of_168_mhz;

/// As in its user manual (UM1724).
pub const NAME: &str = "NUCLEO-F446RE";

/// The core's clock \[Hz\].
pub const CORE_HZ: u32 = 168_000_000;

pub use super::one_bank::*;

/// 168 MHz from the ST-LINK's 8 MHz.
pub fn clocks() -> embassy_stm32::Config {
    clocks_of_168_mhz(None)
}

/// The drivers' enable pin, PB10.
#[inline(always)]
pub(super) fn set_enable_pin(high: bool) {
    pac::GPIOB.bsrr().write(|w| if high { w.set_bs(10, true) } else { w.set_br(10, true) });
}
