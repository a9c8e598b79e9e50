//! NUCLEO-F429ZI: the reference board. 2 MiB of flash in two banks, 8 MHz from the ST-LINK.

use embassy_stm32::pac;
use embassy_stm32::rcc::PllQDiv;

use super::clocks::clocks_of_168_mhz;
pub(super) use super::random::random;

/// As in its user manual (UM1974).
pub const NAME: &str = "NUCLEO-F429ZI";

/// The core's clock \[Hz\].
pub const CORE_HZ: u32 = 168_000_000;

/// Where the configuration lives: the second bank's first four sectors of 16 KiB, which are erased
/// while the program runs on from the first bank.
pub const STORE: core::ops::Range<u32> = 0x10_0000..0x11_0000;

/// The first one's number in the flash's control register.
pub const STORE_SECTOR: u8 = 0x10;

/// Whether the core stands still while the store is erased.
pub const ERASE_STALLS: bool = false;

/// 168 MHz from the ST-LINK's 8 MHz; 48 MHz for USB comes out of the same loop.
pub fn clocks() -> embassy_stm32::Config {
    clocks_of_168_mhz(Some(PllQDiv::DIV7))
}

/// The drivers' enable pin, PF15.
#[inline(always)]
pub(super) fn set_enable_pin(high: bool) {
    pac::GPIOF.bsrr().write(|w| if high { w.set_bs(15, true) } else { w.set_br(15, true) });
}
