//! Bugs that are injected into the running program: a few instructions of the flashed image are replaced at
//! a chosen moment, so the image needs no test code.

use std::path::Path;

use object::{Object, ObjectSymbol};
use rigless::emulator::{Access, Host};
use rigless::soc::Width;

/// Flash after the image, for instructions that do not fit at the bug's place.
const SPARE: u64 = 0x080F_0000;

/// A bug in the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bug {
    /// Where the bug is.
    pub place: Place,
    /// What the program does there.
    pub effect: Effect,
}

/// Where a bug is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// At the beginning of a function.
    Function(&'static str),
    /// At the next instruction that accesses this register; takes effect the second time the program gets there.
    Register(u64),
}

/// What happens where the bug is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// The program hangs.
    Hang,
    /// The program panics.
    Panic,
    /// The core executes an invalid instruction.
    HardFault,
}

/// Injects bugs; knows the addresses of the image's functions.
#[derive(Debug)]
pub(crate) struct BugInjector {
    functions: Vec<(String, u64)>,
    /// Bugs that wait for an access to their register.
    waiting: Vec<(u64, Effect)>,
    /// Instructions to replace at the next stop.
    found: Vec<(u64, Effect)>,
    /// The replaced instructions, by address.
    replaced: Vec<(u64, u64)>,
}

impl BugInjector {
    pub fn new(image: &Path) -> Result<Self, Box<dyn std::error::Error>> {
        let bytes = std::fs::read(image)?;
        let file = object::File::parse(&*bytes)?;
        let functions = file.symbols().filter_map(|symbol| {
            // The lowest bit marks Thumb code.
            Some((symbol.name().ok()?.to_string(), symbol.address() & !1))
        });
        Ok(Self {
            functions: functions.collect(),
            waiting: Vec::new(),
            found: Vec::new(),
            replaced: Vec::new(),
        })
    }

    pub fn plant(&mut self, bug: Bug, host: &mut dyn Host) {
        match bug.place {
            Place::Function(name) => {
                let address = self.function(|function| function == name);
                self.replace(address.expect("the image has this function"), bug.effect, host);
            }
            Place::Register(address) => self.waiting.push((address, bug.effect)),
        }
    }

    pub fn on_access(&mut self, access: &Access) {
        if self.waiting.is_empty() {
            return;
        }
        let at = self.waiting.iter().position(|(address, _)| *address == access.address);
        if let (Some(at), Some(instruction)) = (at, access.program_counter) {
            let (_, effect) = self.waiting.swap_remove(at);
            self.found.push((instruction, effect));
        }
    }

    /// Replaces instructions that were found. Not at once: the program is about to execute the next one, which may
    /// be replaced too.
    pub fn on_stop(&mut self, host: &mut dyn Host) {
        for (instruction, effect) in std::mem::take(&mut self.found) {
            self.replace(instruction, effect, host);
        }
    }

    fn function(&self, is: impl Fn(&str) -> bool) -> Option<u64> {
        self.functions.iter().find(|(name, _)| is(name)).map(|(_, address)| *address)
    }

    /// Restores the replaced instructions.
    pub fn clean_up(&mut self, host: &mut dyn Host) {
        for (address, half) in self.replaced.drain(..).rev() {
            host.write(address, Width::W16, half).expect("the address is in flash");
        }
        self.waiting.clear();
        self.found.clear();
    }

    fn replace(&mut self, at: u64, effect: Effect, host: &mut dyn Host) {
        for address in [at, at + 2] {
            let half = host.read(address, Width::W16).expect("the address is in flash");
            self.replaced.push((address, half));
        }
        match effect {
            // b . (to itself)
            Effect::Hang => write(host, at, &[0xE7FE]),
            // udf #0
            Effect::HardFault => write(host, at, &[0xDE00]),
            Effect::Panic => {
                let panics = self.function(|name| name.ends_with("option13unwrap_failed"));
                let panics = panics.expect("somewhere in the image an option is unwrapped");
                self.write_call(panics, host);
                write(host, at, &branch(at, SPARE));
            }
        }
    }

    /// Writes to [`SPARE`] a call of a function that takes a `core::panic::Location`.
    fn write_call(&self, function: u64, host: &mut dyn Host) {
        // ldr r0, [pc, #8]; mov r1, r0; ldr r3, [pc, #8]; mov r2, r0; bx r3; nop
        write(host, SPARE, &[0x4802, 0x4601, 0x4B02, 0x4602, 0x4718, 0xBF00]);
        let location = SPARE + 20;
        let name = SPARE + 36;
        let words =
            [location, function | 1, name, 3, 1, 1, u64::from(u32::from_le_bytes(*b"bug\0"))];
        for (index, word) in words.into_iter().enumerate() {
            host.write(SPARE + 12 + 4 * index as u64, Width::W32, word)
                .expect("the address is in flash");
        }
    }
}

fn write(host: &mut dyn Host, at: u64, halves: &[u16]) {
    for (index, &half) in halves.iter().enumerate() {
        host.write(at + 2 * index as u64, Width::W16, half.into())
            .expect("the address is in flash");
    }
}

/// `b.w`, encoding T4 of the Armv7-M manual (A7.7.12).
fn branch(from: u64, to: u64) -> [u16; 2] {
    let offset = to.wrapping_sub(from + 4);
    let bit = |number: u64| offset >> number & 1;
    let (s, i1, i2) = (bit(24), bit(23), bit(22));
    let (j1, j2) = (i1 ^ s ^ 1, i2 ^ s ^ 1);
    let high = 0xF000 | s << 10 | offset >> 12 & 0x3FF;
    let low = 0x9000 | j1 << 13 | j2 << 11 | offset >> 1 & 0x7FF;
    [high as u16, low as u16]
}

#[cfg(test)]
mod tests {
    use super::branch;

    #[test]
    fn a_branch_is_encoded_as_the_assembler_does() {
        // `b.w . + 0x1000` and `b.w . - 0x1000`, as GNU as has them.
        assert_eq!(branch(0x0800_0000, 0x0800_1000), [0xF000, 0xBFFE]);
        assert_eq!(branch(0x0800_1000, 0x0800_0000), [0xF7FE, 0xBFFE]);
    }
}
