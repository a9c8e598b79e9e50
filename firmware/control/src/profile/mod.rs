//! Trapezoidal motions of both wheels.
//!
//! # Accounting
//!
//! A [`Plan`] is made once, outside the control tick: ramp to a cruise speed, cruise, ramp to zero,
//! for each wheel in continuous time and double precision, so that phases begin between ticks and neither
//! distance nor duration is rounded to whole ticks. Of each phase it keeps position and velocity, in closed form,
//! at the first tick inside. From there on a tick is exact integer arithmetic:
//!
//! ```text
//! s(n) = s(0) + n v(0) + n^2 h,   v(n) = v(0) + 2 n h,   h half the acceleration    (1)
//! s <- s + v + h,   v <- v + 2 h                                                    (2), the same step by step
//! ```
//!
//! with s in 2^-64 m, v in 2^-64 m per tick and h in 2^-64 m per tick^2. Nothing is rounded inside a
//! phase, so nothing drifts, and the end of a plan is its target to the last bit. Where two phases
//! meet, the rounding of h shows as n^2 2^-64 m at most: 1.5 pm for the paper's ramps of 5178 ticks,
//! 54 nm for the longest ramp of 1000 s; and double precision as some 2^-52 of the distance, 10 pm in 20 km.

mod plan;
mod ramps;
mod state;
mod trajectory;

pub use plan::Plan;
pub use state::{Position, ProfileState, Setpoint, Velocity};

use shared_proto::WheelPair;

use trajectory::Cursor;

/// Follows one plan after the other, tick by tick.
///
/// Two plans have their places here and are never moved: the one that is followed, and the one that waits.
#[derive(Clone, Debug)]
pub struct Profile {
    slots: [Slot; 2],
    /// The second seat's plan is followed, not the first one's.
    second: bool,
    /// The other seat's plan waits for its start.
    waiting: bool,
    /// The plan that is followed has come to its end, and its wheels stand for ever.
    ended: bool,
}

/// A plan, and how far the wheels have come on it.
#[derive(Clone, Debug)]
struct Slot {
    plan: Plan,
    cursors: WheelPair<Cursor>,
}

impl Slot {
    #[inline]
    fn take(&mut self, plan: &Plan) {
        self.plan.clone_from(plan);
        self.cursors = WheelPair {
            left: Cursor::new(&plan.trajectories.left),
            right: Cursor::new(&plan.trajectories.right),
        };
    }
}

impl Profile {
    /// Stands still at the origin.
    pub const ORIGIN: Self = {
        const SLOT: Slot = Slot { plan: Plan::ORIGIN, cursors: WheelPair::both(Cursor::ORIGIN) };
        Self { slots: [SLOT; 2], second: false, waiting: false, ended: false }
    };

    /// Follows `plan`; before its start it stands at the plan's first point.
    pub fn new(plan: Plan) -> Self {
        let mut profile = Self::ORIGIN;
        profile.replace(&plan);
        profile.switch();
        profile
    }

    /// Goes over to `plan` at its start tick, or at once to a [`Plan::hold`]; until then the present
    /// one is followed.
    ///
    /// For a motion without a jump, plan from [`Profile::at`] the start tick. A plan that waits
    /// already is dropped.
    #[inline]
    pub fn replace(&mut self, plan: &Plan) {
        self.slots[usize::from(!self.second)].take(plan);
        self.waiting = true;
    }

    /// Goes over to the plan that waits, before its start: the wheels stand at its first point.
    pub const fn switch(&mut self) {
        if self.waiting {
            self.second = !self.second;
            self.waiting = false;
            self.ended = false;
        }
    }

    /// Drops the plan that waits if its start is past: the wheels would jump. True if it did.
    pub fn drop_late(&mut self, tick: u32) -> bool {
        let next = &self.slots[usize::from(!self.second)].plan;
        let late = self.waiting && tick.wrapping_sub(next.start_tick()) as i32 > 0;
        self.waiting &= !late;
        late
    }

    /// State of both wheels at `tick`, now or later, as the plan that is followed now has it.
    #[inline]
    pub fn at(&self, tick: u32) -> WheelPair<ProfileState> {
        let plan = &self.slots[usize::from(self.second)].plan;
        plan.at(if self.ended { plan.end_tick() } else { tick })
    }

    /// The setpoints at `tick`. Cheapest when called at every tick; catches up if ticks were missed.
    #[inline(never)]
    pub fn step(&mut self, tick: u32) -> WheelPair<Setpoint> {
        if self.waiting {
            let next = &self.slots[usize::from(!self.second)].plan;
            if !next.has_start || reached(tick, next.start_tick()) {
                self.switch();
            }
        }
        let Slot { plan, cursors } = &mut self.slots[usize::from(self.second)];
        let elapsed = if self.ended { plan.len_ticks() } else { plan.elapsed(tick) };
        // A plan is told from one that has not begun for 2^31 ticks only; standing still is for ever.
        self.ended = elapsed >= plan.len_ticks();
        cursors.left.advance_to(&plan.trajectories.left, elapsed);
        cursors.right.advance_to(&plan.trajectories.right, elapsed);
        WheelPair { left: cursors.left.setpoint(), right: cursors.right.setpoint() }
    }

    /// True if at `tick`, now or later, both wheels are at the target of the last plan given.
    #[inline(always)]
    pub fn finished(&self, tick: u32) -> bool {
        if !self.waiting && self.ended {
            return true;
        }
        let last = &self.slots[usize::from(self.second != self.waiting)].plan;
        !last.has_start || reached(tick, last.end_tick())
    }
}

/// True if `tick` is at most 2^31 ticks after `goal`.
fn reached(tick: u32, goal: u32) -> bool {
    tick.wrapping_sub(goal) as i32 >= 0
}
