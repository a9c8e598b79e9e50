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

/// Counts that the pins may be behind.
const BEHIND_MAX: u64 = 8;

/// The lines of both encoders.
#[derive(Debug)]
pub(crate) struct EncoderLines {
    faults: WheelPair<Option<LineFault>>,
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
            faults: WheelPair::both(None),
            renew: WheelPair::both(false),
            shown: WheelPair::both(0),
            noise: 1,
        }
    }
}

impl EncoderLines {
    pub fn set(&mut self, wheel: Wheel, fault: Option<LineFault>) {
        *self.faults.get_mut(wheel) = fault;
        *self.renew.get_mut(wheel) = true;
    }

    /// The pins' levels on the way to a count, if they may have changed. Line A leads while the count rises.
    pub fn levels(&mut self, wheel: Wheel, count: i64) -> Option<[Level; 2]> {
        let shown = self.shown.get_mut(wheel);
        let (fault, step) = (*self.faults.get(wheel), (count - *shown).signum());
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
        let floats = matches!(fault, Some(LineFault::Floats(_)));
        if step == 0 && !renew && !floats {
            return None;
        }
        let (line, high) = match fault {
            None => return Some(levels),
            Some(LineFault::Stuck { line, high }) => (line, high),
            Some(LineFault::Floats(line)) => (line, self.toss()),
        };
        levels[line as usize] = if high { Level::High } else { Level::Low };
        Some(levels)
    }

    /// A level by chance, the same in every run.
    fn toss(&mut self) -> bool {
        self.noise = self.noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        self.noise >> 63 != 0
    }
}
