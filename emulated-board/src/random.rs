//! The chip's generator of random numbers (RM0090, chapter 24): the emulator has its registers, but no numbers for them.

use rigless::emulator::{Access, AccessKind};
use rigless::mcu::Mcu;
use rigless::soc::stm32f427::generated::rng::Register;

use crate::board::Nucleo;

/// The peripheral, as the emulator calls it.
pub(crate) const INSTANCE: &str = "RNG";

/// Control and data.
const CR: u64 = 0x5006_0800;
const DR: u64 = 0x5006_0808;

/// `RNG_CR`: on.
const RNGEN: u64 = 1 << 2;

/// `RNG_SR`: there is a number; the numbers are not random.
const DRDY: u64 = 1;
const SECS: u64 = 1 << 2;

/// The generator. Its numbers differ from start to start, and are the same in every run.
#[derive(Debug, Default)]
pub(crate) struct Generator {
    drawn: u64,
}

impl Generator {
    /// `value`: what was read, or written; `fails`: the generator says that it is broken.
    pub fn on_access(&mut self, access: &Access, value: u64, fails: bool, board: &mut Nucleo) {
        let mut set = |register, value| {
            let bus = board.mcu.bus_mut();
            let slot = bus.slot_of(INSTANCE).expect("a chip has a generator");
            bus.slot_mut(slot).registers_mut().set(register, value);
        };
        match (access.address, access.kind == AccessKind::Write) {
            (CR, true) if value & RNGEN == 0 => set(Register::Sr, 0),
            (CR, true) => {
                set(Register::Sr, if fails { SECS } else { DRDY });
                set(Register::Dr, self.next());
            }
            (DR, false) => set(Register::Dr, self.next()),
            _ => {}
        }
    }

    /// The next word: SplitMix64's.
    fn next(&mut self) -> u64 {
        self.drawn += 1;
        let mut word = self.drawn.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        word = (word ^ (word >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (word ^ (word >> 31)) >> 32
    }
}
