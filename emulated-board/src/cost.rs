//! What a control tick costs, counted instruction by instruction.
//!
//! ```text
//! clock's interrupt   control's interrupt: capture, profile, PID           (its last instruction)
//! |- begin            |- read encoders ......... write PWM .... publish -| end
//! ```
//!
//! From the first instruction of the clock's interrupt (`TIM5`) that makes a tick due, to the last
//! instruction of the interrupt that the control tasks run in (`UART7`): the clock's queue, the executor
//! and whatever interrupts them included. The first 50 ms are not
//! counted: the board starts up in them.

use std::path::Path;

use object::{Object, ObjectSymbol};
use rigless::emulator::{Access, AccessKind, Hit, Watch};
use rigless::time::VirtualNanos;

/// Ticks before this time belong to the start \[us\].
const START_US: u64 = 50_000;

/// The register whose writing ends a tick's way to the motors: TIM1's third compare value.
const PWM_RIGHT: u64 = 0x4001_003C;

/// What one control tick took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TickCost {
    /// When it began \[us\].
    pub t_us: u64,
    /// Instructions from begin to end.
    pub instructions: u64,
    /// Instructions from begin until the PWM was written.
    pub to_pwm: u64,
}

/// Counts control ticks.
#[derive(Debug, Default)]
pub(crate) struct Counter {
    clock: u64,
    control: std::ops::Range<u64>,
    begin: Option<(VirtualNanos, u64)>,
    pwm: Option<u64>,
    last: Option<u64>,
    pub ticks: Vec<TickCost>,
}

impl Counter {
    /// A counter for this image, and what has to be watched for it.
    pub fn new(image: &Path) -> Result<(Self, Vec<Watch>), Box<dyn std::error::Error>> {
        let bytes = std::fs::read(image)?;
        let file = object::File::parse(&*bytes)?;
        let function = |name: &str| {
            let found = file.symbol_by_name(name);
            let found = found.ok_or_else(|| format!("the image has no function {name}"))?;
            // The lowest bit says that it is in Thumb code.
            let start = found.address() & !1;
            Ok::<_, Box<dyn std::error::Error>>(start..start + found.size())
        };
        let counter =
            Self { clock: function("TIM5")?.start, control: function("UART7")?, ..Self::default() };
        let inside = counter.control.clone().step_by(2).map(Watch::Instruction);
        let watches = inside.chain([Watch::Instruction(counter.clock)]).collect();
        Ok((counter, watches))
    }

    pub fn on_hit(&mut self, hit: &Hit) {
        if hit.address == self.clock {
            self.finish();
            self.begin = Some((hit.at, hit.instruction_count));
        } else if self.control.contains(&hit.address) {
            self.last = Some(hit.instruction_count + 1);
        }
    }

    pub fn on_access(&mut self, access: &Access) {
        if access.kind == AccessKind::Write && access.address == PWM_RIGHT {
            self.pwm = Some(access.instruction_count);
        }
    }

    /// A tick is over when the next one begins; what had no control in it was another timer's.
    fn finish(&mut self) {
        if let (Some((at, begin)), Some(pwm), Some(last)) =
            (self.begin, self.pwm.take(), self.last.take())
        {
            let t_us = at.0 / 1000;
            if t_us >= START_US {
                self.ticks.push(TickCost { t_us, instructions: last - begin, to_pwm: pwm - begin });
            }
        }
    }
}
