//! NUCLEO-F429ZI: the reference board. 2 MiB of flash in two banks, 8 MHz from the ST-LINK.

use embassy_stm32::pac;
use embassy_stm32::rcc::PllQDiv;
use shared_proto::Nonce;

use super::clocks::clocks_of_168_mhz;

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

/// How many words are drawn: four, and one that only the next is compared with.
const DRAWS: usize = 5;

/// Random numbers of the chip's generator (RM0090, chapter 24); none if it reports an error or repeats itself.
pub(super) fn random() -> Option<Nonce> {
    pac::RCC.ahb2enr().modify(|w| w.set_rngen(true));
    let _ = pac::RCC.ahb2enr().read();
    pac::RNG.cr().modify(|w| w.set_rngen(true));
    let mut words = [0_u32; DRAWS];
    let mut good = true;
    for i in 0..DRAWS {
        // A word takes 40 cycles of 48 MHz.
        good &= (0..1000).any(|_| pac::RNG.sr().read().drdy());
        let status = pac::RNG.sr().read();
        good &= !status.secs() && !status.cecs();
        words[i] = pac::RNG.dr().read();
        // The check of FIPS 140-2 that the manual asks for.
        good &= i == 0 || words[i] != words[i - 1];
    }
    pac::RNG.cr().modify(|w| w.set_rngen(false));
    pac::RCC.ahb2enr().modify(|w| w.set_rngen(false));
    let mut nonce = Nonce::default();
    for (bytes, word) in nonce.as_chunks_mut::<4>().0.iter_mut().zip(&words[1..]) {
        *bytes = word.to_le_bytes();
    }
    good.then_some(nonce)
}

/// The drivers' enable pin, PF15.
#[inline(always)]
pub(super) fn set_enable_pin(high: bool) {
    pac::GPIOF.bsrr().write(|w| if high { w.set_bs(15, true) } else { w.set_br(15, true) });
}
