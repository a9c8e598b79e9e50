//! The encoders' lines between plug and pin, and what can happen to them.

use rigless::device::Level;
use shared_proto::{Wheel, WheelPair};

/// One of an encoder's two lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// Leads while the wheel rolls forward.
    A,
    /// Follows by a quarter of a period.
    B,
}

/// What is wrong with one encoder's lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineFault {
    /// The line stays at this level: cut, or shorted to ground or supply.
    Stuck {
        /// Which line.
        line: Line,
        /// High.
        high: bool,
    },
    /// The line is cut and floats: a level by chance at every look, which is every 50 us.
    Floats(Line),
}

impl LineFault {
    /// The line.
    fn line(self) -> Line {
        match self {
            LineFault::Stuck { line, .. } | LineFault::Floats(line) => line,
        }
    }
}

/// Counts that the pins may be behind.
const BEHIND_MAX: u64 = 8;

/// The lines of both encoders.
#[derive(Debug)]
pub(crate) struct EncoderLines {
    /// Of each line its own: a second one does not mend the first.
    faults: WheelPair<[Option<LineFault>; 2]>,
    /// The levels have changed although the wheel may stand.
    renew: WheelPair<bool>,
    /// The count that the pins show: one further at every look at most. A count that jumps a little, as by
    /// interference, is made up for. Levels that change more often at one instant would tell the decoder nothing.
    shown: WheelPair<i64>,
    noise: u64,
}

impl Default for EncoderLines {
    fn default() -> Self {
        Self {
            faults: WheelPair::both([None; 2]),
            renew: WheelPair::both(false),
            shown: WheelPair::both(0),
            noise: 1,
        }
    }
}

impl EncoderLines {
    /// Breaks one of the lines, or mends both.
    pub fn set(&mut self, wheel: Wheel, fault: Option<LineFault>) {
        let faults = self.faults.get_mut(wheel);
        match fault {
            None => *faults = [None; 2],
            Some(fault) => faults[fault.line() as usize] = Some(fault),
        }
        *self.renew.get_mut(wheel) = true;
    }

    /// Shows the levels again, to a chip that has restarted.
    pub fn show_again(&mut self) {
        self.renew = WheelPair::both(true);
    }

    /// The pins' levels on the way to a count, if they may have changed. Line A leads while the count rises.
    pub fn levels(&mut self, wheel: Wheel, count: i64) -> Option<[Level; 2]> {
        let shown = self.shown.get_mut(wheel);
        let (faults, step) = (*self.faults.get(wheel), (count - *shown).signum());
        *shown += step;
        // Whole periods that are far behind are let go: no decoder sees them.
        if shown.abs_diff(count) > BEHIND_MAX {
            *shown += (count - *shown) / 4 * 4;
        }
        let mut levels = match shown.rem_euclid(4) {
            0 => [Level::Low, Level::Low],
            1 => [Level::High, Level::Low],
            2 => [Level::High, Level::High],
            _ => [Level::Low, Level::High],
        };
        let renew = std::mem::take(self.renew.get_mut(wheel));
        let floats = faults.iter().any(|fault| matches!(fault, Some(LineFault::Floats(_))));
        if step == 0 && !renew && !floats {
            return None;
        }
        for fault in faults.into_iter().flatten() {
            let high = match fault {
                LineFault::Stuck { high, .. } => high,
                LineFault::Floats(_) => self.toss(),
            };
            levels[fault.line() as usize] = if high { Level::High } else { Level::Low };
        }
        Some(levels)
    }

    /// A level by chance, the same in every run.
    fn toss(&mut self) -> bool {
        self.noise = self.noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        self.noise >> 63 != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_line_that_breaks_does_not_mend_the_first() {
        let mut lines = EncoderLines::default();
        let of = |line, high| Some(LineFault::Stuck { line, high });
        lines.set(Wheel::Left, of(Line::B, true));
        lines.set(Wheel::Left, of(Line::A, false));
        for count in 1..9 {
            assert_eq!(lines.levels(Wheel::Left, count), Some([Level::Low, Level::High]));
        }
        lines.set(Wheel::Left, None);
        assert_eq!(lines.levels(Wheel::Left, 9), Some([Level::High, Level::Low]));
    }
}
