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
/// From v to rest within 3 q: v^2 = 6 a q. In 2^-24 m per tick that is four counts times 2^6, at a = 2.5 m/s^2: more than twice
/// what friction does to the paper's robot.
const BRAKED: u32 = 6 - 2 * 2;
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

    /// Travel over the newest changes, and the ticks from the first of them until this one \[2^-24 m\].
    #[inline(never)]
    pub fn recent_travel(&self, until: u32) -> (u32, u32) {
        let age = LATELY.min(self.len);
        (self.between(age, 1).travel.unsigned_abs(), until.wrapping_sub(self.change(age).tick))
    }

    /// How fast the wheel was on average over the newest changes, until this tick \[2^-24 m/tick\].
    #[inline(never)]
    pub fn mean_speed(&self, until: u32) -> i32 {
        let (turned, ticks) = self.recent_travel(until);
        (turned / ticks.max(1)) as i32
    }

    /// The wheel still kept up with its setpoint and did not slow down. Asked only where they are
    /// [not few](Self::are_few).
    pub fn end_abruptly(&self) -> bool {
        let last = self.between(self.window(), 1);
        // Two thirds.
        let kept_up = 3 * last.travel > 2 * last.setpoint;
        kept_up && !self.slowed_down()
    }

    /// Its setpoint advanced further through the last two changes than through the two before: the wheel was slower.
    fn slowed_down(&self) -> bool {
        let (last, earlier) = (self.between(3, 1), self.between(5, 3));
        let ticks = self.change(1).tick.wrapping_sub(self.change(3).tick);
        ticks >= SLOW_TICKS && 4 * earlier.setpoint < 3 * last.setpoint
    }

    /// So slow at the last change that friction stops a wheel without current within three counts: then they end as abruptly
    /// as those of a plug that is pulled.
    pub fn were_slow(&self, four_counts: i32) -> bool {
        // In steps of 4: no square of a speed overflows.
        let speed = self.mean_speed(self.change(1).tick) >> 2;
        speed * speed <= four_counts << BRAKED
    }

    /// The `age`-th newest change, from 1.
    fn change(&self, age: usize) -> &Change {
        &self.ring[self.len.wrapping_sub(age) % LEN]
    }

    /// The age of a change [`LAST_TICKS`] before the newest, and two changes; at most five, for no two changes fall into one
    /// tick.
    fn window(&self) -> usize {
        let last = self.change(1).tick;
        let mut age = TWO_CHANGES;
        while last.wrapping_sub(self.change(age).tick) < LAST_TICKS {
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
