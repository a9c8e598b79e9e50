//! What a control tick costs, counted instruction by instruction.
//!
//! ```text
//! timer's interrupt (TIM2), in it the control tasks' executor
//! |- begin: clear the timer's flag, wake -- capture ---- profile ---- PID -- write PWM -- publish -| end
//!                                           [======]     [======]    [===]
//!                                              bare arithmetic, both wheels
//! ```
//!
//! A whole tick runs from the first instruction of the interrupt that finds the timer's flag set to the last
//! instruction of the last interrupt in which the tasks run; interrupts in between are included. The bare
//! arithmetic is three functions and what they call: counts to travel and speed, the profile's step, the two
//! PID steps. The first 50 ms, while the board starts, are not counted.

use std::ops::Range;
use std::path::Path;

use object::{Object, ObjectSymbol};
use rigless::emulator::{Access, AccessKind, Hit, Watch};
use rigless::time::VirtualNanos;

/// Ticks before this time are not counted \[us\].
const START_US: u64 = 50_000;

/// A write to this register, TIM2's status, clears the timer's flag.
const TICK_FLAG: u64 = 0x4000_0010;

/// A write to this register, TIM1's fourth compare value, completes the motors' update.
const PWM_RIGHT: u64 = 0x4001_0040;

/// The bare arithmetic's functions, as parts of their mangled names.
const ARITHMETIC: [&[&str]; 3] = [
    &["7control", "7capture7Capture", "4step"],
    &["7control", "7profile7Profile", "4step"],
    &["7control", "3pid", "9step_both"],
];

/// The cost of one control tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TickCost {
    /// When the tick began \[us\].
    pub t_us: u64,
    /// Instructions from begin to end.
    pub instructions: u64,
    /// Instructions from begin until the PWM was written.
    pub to_pwm: u64,
    /// Instructions of the bare arithmetic: capture, profile, PID. Without a motion only capture works.
    pub arithmetic: [u64; 3],
}

impl TickCost {
    /// Instructions of the bare arithmetic, all three parts.
    pub fn bare(&self) -> u64 {
        self.arithmetic.iter().sum()
    }

    /// True if the wheels follow a profile in this tick, so that all three parts run.
    pub fn drives(&self) -> bool {
        self.arithmetic.iter().all(|&part| part > 0)
    }
}

/// Smallest, median and largest of a count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spread {
    /// The smallest.
    pub least: u64,
    /// The median.
    pub median: u64,
    /// The largest: the worst case.
    pub worst: u64,
}

impl Spread {
    /// The spread of a count over these ticks; `None` without ticks.
    pub fn of(ticks: &[TickCost], count: impl Fn(&TickCost) -> u64) -> Option<Self> {
        let mut counts: Vec<u64> = ticks.iter().map(count).collect();
        counts.sort_unstable();
        let (&least, &worst) = (counts.first()?, counts.last()?);
        Some(Self { least, median: counts[counts.len() / 2], worst })
    }
}

/// Counts control ticks.
#[derive(Debug, Default)]
pub(crate) struct Counter {
    interrupt: Range<u64>,
    arithmetic: [Function; 3],
    /// The interrupt's latest entry.
    entered: Option<(VirtualNanos, u64)>,
    begin: Option<(VirtualNanos, u64)>,
    pwm: Option<u64>,
    /// After the interrupt's latest instruction, and after the latest one before its latest entry.
    last: Option<u64>,
    end: Option<u64>,
    pub ticks: Vec<TickCost>,
}

/// A function, and its instructions in this tick.
#[derive(Debug, Default)]
struct Function {
    code: Range<u64>,
    entered: u64,
    instructions: u64,
}

impl Counter {
    /// A counter for this image, and the watches that it needs.
    pub fn new(image: &Path) -> Result<(Self, Vec<Watch>), Box<dyn std::error::Error>> {
        let bytes = std::fs::read(image)?;
        let file = object::File::parse(&*bytes)?;
        let function = |parts: &[&str]| {
            let mut found = file.symbols().filter(|symbol| {
                symbol.size() > 0
                    && symbol.name().is_ok_and(|name| {
                        if parts.len() == 1 {
                            return name == parts[0];
                        }
                        let mut rest = name;
                        parts.iter().all(|part| match rest.split_once(part) {
                            Some((_, after)) => {
                                rest = after;
                                true
                            }
                            None => false,
                        })
                    })
            });
            let symbol = found.next().ok_or_else(|| format!("the image has no {parts:?}"))?;
            if found.next().is_some() {
                return Err(format!("the image has more than one {parts:?}"));
            }
            // The lowest bit marks Thumb code.
            let start = symbol.address() & !1;
            Ok(start..start + symbol.size())
        };
        let mut counter = Self { interrupt: function(&["TIM2"])?, ..Self::default() };
        for (slot, parts) in counter.arithmetic.iter_mut().zip(ARITHMETIC) {
            slot.code = function(parts)?;
        }
        let watches = std::iter::once(&counter.interrupt)
            .chain(counter.arithmetic.iter().map(|function| &function.code))
            .flat_map(|code| code.clone().step_by(2).map(Watch::Instruction))
            .collect();
        Ok((counter, watches))
    }

    pub fn on_hit(&mut self, hit: &Hit) {
        if self.interrupt.contains(&hit.address) {
            if hit.address == self.interrupt.start {
                self.end = self.last;
                self.entered = Some((hit.at, hit.instruction_count));
            }
            self.last = Some(hit.instruction_count + 1);
            return;
        }
        for function in &mut self.arithmetic {
            if hit.address == function.code.start {
                function.entered = hit.instruction_count;
            }
            if function.code.contains(&hit.address) {
                function.instructions = hit.instruction_count + 1 - function.entered;
            }
        }
    }

    pub fn on_access(&mut self, access: &Access) {
        if access.kind != AccessKind::Write {
            return;
        }
        match access.address {
            TICK_FLAG => {
                self.finish();
                self.begin = self.entered;
            }
            PWM_RIGHT => self.pwm = Some(access.instruction_count),
            _ => {}
        }
    }

    /// A tick is over when the next one begins.
    fn finish(&mut self) {
        let arithmetic = self.arithmetic.each_mut().map(|f| std::mem::take(&mut f.instructions));
        if let (Some((at, begin)), Some(pwm), Some(last)) =
            (self.begin, self.pwm.take(), self.end.take())
        {
            let t_us = at.0 / 1000;
            if t_us >= START_US {
                self.ticks.push(TickCost {
                    t_us,
                    instructions: last - begin,
                    to_pwm: pwm - begin,
                    arithmetic,
                });
            }
        }
    }
}
