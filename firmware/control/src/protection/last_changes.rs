//! The last changes of a count: was the wheel slowing down before it stood?

use super::sample::Positions;

/// A change of the count.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    pub tick: u32,
    pub positions: Positions,
}

impl Change {
    pub const BLANK: Self = Self { tick: 0, positions: Positions { setpoint: 0, travel: 0 } };
}

/// Changes kept, so that 4 ticks are covered at one change a tick; a power of two.
const LEN: usize = 8;
/// Two changes, as ages from the newest, and ticks over which the rate before a standstill is taken.
///
/// Few, to see a wheel slow down over about 4 counts. At 2 ms per count, as at the paper's cruise, one tick
/// of quantisation is a quarter of the time; the factor of two thirds allows for that.
const TWO_CHANGES: usize = 3;
const LAST_TICKS: u32 = 4;
/// Two changes that take less than this do not tell whether the wheel is slower than before. Before it stands it is.
const SLOW_TICKS: u32 = 8;
/// The start, and four counts.
const FEW: usize = 5;
/// Changes over which the speed of a wheel is taken that turns the wrong way.
const LATELY: usize = 4;

/// The last changes that led to a new count.
#[derive(Clone, Copy, Debug)]
pub struct LastChanges {
    /// The newest one is at `len - 1`; before the first one, entry 0 is the start.
    ring: [Change; LEN],
    len: usize,
}

/// Travel of setpoint and wheel, both along the setpoint's \[2^-24 m\].
struct Moved {
    setpoint: i32,
    travel: i32,
}

impl LastChanges {
    pub const BLANK: Self = Self { ring: [Change::BLANK; LEN], len: 0 };

    /// Resets only what will be read.
    pub fn begin(&mut self, start: Change) {
        self.ring[0] = start;
        self.len = 1;
    }

    #[inline(always)]
    pub fn push(&mut self, change: Change) {
        self.ring[self.len % LEN] = change;
        self.len = self.len.wrapping_add(1);
    }

    /// So few since the loop closed that they do not tell how fast the wheel was when it stood, or whether it turned.
    pub fn are_few(&self) -> bool {
        self.len <= FEW
    }

    /// How fast the wheel was until this tick \[2^-24 m/tick\].
    pub fn speed_at(&self, tick: u32) -> i32 {
        let (turned, ticks) = self.recent_travel();
        let standing = tick.wrapping_sub(self.change(1).tick);
        (turned / (ticks + standing).max(1)) as i32
    }

    /// Travel over the newest changes \[2^-24 m\], and its ticks.
    #[inline(never)]
    pub fn recent_travel(&self) -> (u32, u32) {
        let age = LATELY.min(self.len);
        let ticks = self.change(1).tick.wrapping_sub(self.change(age).tick);
        (self.between(age, 1).travel.unsigned_abs(), ticks)
    }

    /// The wheel still kept up with its setpoint and did not slow down.
    pub fn end_abruptly(&self) -> bool {
        let last = self.between(self.window(), 1);
        // Two thirds.
        let kept_up = 3 * last.travel > 2 * last.setpoint;
        kept_up && !self.slowed_down()
    }

    /// Its setpoint advanced further through the last two changes than through the two before: the wheel was slower. Asked
    /// only where they are [not few](Self::are_few).
    fn slowed_down(&self) -> bool {
        let (last, earlier) = (self.between(3, 1), self.between(5, 3));
        let ticks = self.change(1).tick.wrapping_sub(self.change(3).tick);
        ticks >= SLOW_TICKS && 4 * earlier.setpoint < 3 * last.setpoint
    }

    /// The `age`-th newest change, from 1.
    fn change(&self, age: usize) -> &Change {
        &self.ring[self.len.wrapping_sub(age) % LEN]
    }

    /// The age of a change [`LAST_TICKS`] before the newest, and two changes.
    fn window(&self) -> usize {
        let (known, last) = (self.len.min(LEN), self.change(1).tick);
        let mut age = TWO_CHANGES.min(known);
        while age < known && last.wrapping_sub(self.change(age).tick) < LAST_TICKS {
            age += 1;
        }
        age
    }

    /// From one change to a later one.
    #[inline(never)]
    fn between(&self, earlier: usize, later: usize) -> Moved {
        let moved = self.change(later).positions.since(self.change(earlier).positions);
        let Positions { setpoint, travel } = moved;
        match setpoint {
            0.. => Moved { setpoint, travel },
            _ => Moved { setpoint: setpoint.wrapping_neg(), travel: travel.wrapping_neg() },
        }
    }
}
