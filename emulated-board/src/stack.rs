//! How deep the stack has been: it is painted before the first instruction, and searched at the end for the paint.

use std::ops::Range;
use std::path::Path;

use object::{Object, ObjectSymbol};
use rigless::emulator::Host;
use rigless::soc::Width;

/// Not what a program is likely to push.
const PAINT: u64 = 0xC5C5_5A5A;

/// The memory of the stack.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Stack(Range<u64>);

/// How much of it was used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StackDepth {
    /// The deepest, since power-on and over restarts \[bytes\].
    pub used: u64,
    /// What there is \[bytes\].
    pub size: u64,
}

impl Stack {
    /// The stack of an image, as its linker script has it.
    pub fn of(image: &Path) -> Result<Self, Box<dyn std::error::Error>> {
        let bytes = std::fs::read(image)?;
        let file = object::File::parse(&*bytes)?;
        let address = |name: &str| {
            let symbol = file.symbols().find(|symbol| symbol.name() == Ok(name));
            symbol.map(|symbol| symbol.address()).ok_or_else(|| format!("the image has no {name}"))
        };
        Ok(Self(address("_stack_end")?..address("_stack_start")?))
    }

    pub(crate) fn paint(&self, host: &mut dyn Host) {
        for address in self.0.clone().step_by(4) {
            host.write(address, Width::W32, PAINT).expect("it is memory");
        }
    }

    pub(crate) fn depth(&self, host: &mut dyn Host) -> StackDepth {
        let is_painted = |address: &u64| host.read(*address, Width::W32).ok() == Some(PAINT);
        let clean = self.0.clone().step_by(4).take_while(is_painted).count() as u64;
        let size = self.0.end - self.0.start;
        StackDepth { used: size - 4 * clean, size }
    }
}
