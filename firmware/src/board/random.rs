//! Random numbers, on chips with a generator of them: RM0090, chapter 24; RM0440, chapter 26. Its clock is 48 MHz on both.

use embassy_stm32::pac::{RCC, RNG};
use shared_proto::Nonce;

/// How many words are drawn: four, and one that only the next is compared with.
const DRAWS: usize = 5;

/// Random numbers of the chip's generator; none if it reports an error or repeats itself.
pub(super) fn random() -> Option<Nonce> {
    RCC.ahb2enr().modify(|w| w.set_rngen(true));
    let _ = RCC.ahb2enr().read();
    RNG.cr().modify(|w| w.set_rngen(true));
    let mut words = [0_u32; DRAWS];
    let mut good = true;
    for i in 0..DRAWS {
        // On an F4 a word takes 40 cycles of 48 MHz. On a G4 the first takes 128, and 426 of the core's clock.
        good &= (0..1000).any(|_| RNG.sr().read().drdy());
        let status = RNG.sr().read();
        good &= !status.secs() && !status.cecs();
        words[i] = RNG.dr().read();
        // The check of FIPS 140-2 that RM0090 asks for.
        good &= i == 0 || words[i] != words[i - 1];
    }
    RNG.cr().modify(|w| w.set_rngen(false));
    RCC.ahb2enr().modify(|w| w.set_rngen(false));
    let mut nonce = Nonce::default();
    for (bytes, word) in nonce.as_chunks_mut::<4>().0.iter_mut().zip(&words[1..]) {
        *bytes = word.to_le_bytes();
    }
    good.then_some(nonce)
}
