//! NUCLEO-F446RE: 512 KiB of flash in one bank, 8 MHz from the ST-LINK.

use embassy_stm32::pac;
use shared_proto::Nonce;

use super::clocks::clocks_of_168_mhz;

/// As in its user manual (UM1724).
pub const NAME: &str = "NUCLEO-F446RE";

/// The core's clock \[Hz\].
pub const CORE_HZ: u32 = 168_000_000;

/// Where the configuration lives: sectors 1 to 3, of 16 KiB each. The vectors are in sector 0 and
/// the program begins in sector 4: see `memory/nucleo_f446re.x`.
pub const STORE: core::ops::Range<u32> = 0x4000..0x1_0000;

/// The first one's number in the flash's control register.
pub const STORE_SECTOR: u8 = 1;

/// Whether the core stands still while the store is erased: there is one bank, which the program
/// runs from.
pub const ERASE_STALLS: bool = true;

/// 168 MHz from the ST-LINK's 8 MHz.
pub fn clocks() -> embassy_stm32::Config {
    clocks_of_168_mhz(None)
}

/// This chip has no generator of random numbers: the store's count of starts has to do.
pub(super) fn random() -> Option<Nonce> {
    None
}

/// The driver's enable pin low: PB10.
pub(super) fn driver_disable() {
    pac::GPIOB.bsrr().write(|w| w.set_br(10, true));
}
