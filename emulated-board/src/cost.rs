//! What a control tick costs, counted instruction by instruction.
//!
//! ```text
//! timer's interrupt (TIM2), in it the control tasks' executor
//! |- begin: clear the timer's flag, wake -- capture ---- profile ---- PID -- write PWM -- publish -| end
//!                                           [======]     [======]    [===]
//!                                              bare arithmetic, both wheels
//! ```
//!
//! A whole tick is everything from the first instruction of the interrupt that finds the timer's flag set to
//! the last instruction of the last interrupt that the tasks had themselves run in; what interrupts it
//! is in it. The bare arithmetic is what is spent in three functions and in what they call: counts to travel
//! and speed, the profile's step, the two PID steps. The first 50 ms are not counted: the board starts up in
//! them.

use std::ops::Range;
use std::path::Path;

use object::{Object, ObjectSymbol};
use rigless::emulator::{Access, AccessKind, Hit, Watch};
use rigless::time::VirtualNanos;

/// Ticks before this time belong to the start \[us\].
const START_US: u64 = 50_000;

/// The register whose writing clears the timer's flag: TIM2's status.
const TICK_FLAG: u64 = 0x4000_0010;

/// The register whose writing ends a tick's way to the motors: TIM1's third compare value.
const PWM_RIGHT: u64 = 0x4001_003C;

/// The bare arithmetic's functions, as pieces of their mangled names.
const ARITHMETIC: [&[&str]; 3] = [
    &["7control", "7capture7Capture", "4step"],
    &["7control", "7profile7Profile", "4step"],
    &["7control", "3pid", "9step_both"],
];

/// What one control tick took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TickCost {
    /// When it began \[us\].
    pub t_us: u64,
    /// Instructions from begin to end.
    pub instructions: u64,
    /// Instructions from begin until the PWM was written.
    pub to_pwm: u64,
    /// Instructions of the bare arithmetic: capture, profile, PID. Without a motion only the first one works.
    pub arithmetic: [u64; 3],
}

impl TickCost {
    /// Instructions of the bare arithmetic, all three parts.
    pub fn bare(&self) -> u64 {
        self.arithmetic.iter().sum()
    }

    /// The wheels follow a profile in this tick: everything is at work.
    pub fn drives(&self) -> bool {
        self.arithmetic.iter().all(|&part| part > 0)
    }
}

/// Least, median and most of something that was counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spread {
    /// The smallest.
    pub least: u64,
    /// As many are above it as below it.
    pub median: u64,
    /// The largest: the worst case.
    pub worst: u64,
}

impl Spread {
    /// Of something in every one of these ticks; `None` without any.
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

/// A function, and what it took in this tick.
#[derive(Debug, Default)]
struct Function {
    code: Range<u64>,
    entered: u64,
    instructions: u64,
}

impl Counter {
    /// A counter for this image, and what has to be watched for it.
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
            // The lowest bit says that it is in Thumb code.
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
