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

mod course;
mod plan;
mod ramps;

pub use plan::Plan;

use fixed::types::{I0F64, I32F32, I64F64};
use shared_proto::WheelPair;

use course::Walker;

use crate::units::{Acceleration, Speed, Travel};

/// A wheel's planned travel \[m\] in steps of 2^-64 m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position(pub I64F64);

/// A wheel's planned velocity \[m per control tick\] in steps of 2^-64, forward positive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Velocity(pub I0F64);

impl From<Travel> for Position {
    fn from(travel: Travel) -> Self {
        Self(I64F64::from_bits(i128::from(travel.0.to_bits()) << 32))
    }
}

impl From<Position> for Travel {
    /// To the nearest step; wraps beyond 2^31 m.
    fn from(position: Position) -> Self {
        Self(I32F32::from_bits(((position.0.to_bits() + (1 << 31)) >> 32) as i64))
    }
}

/// Where a plan has a wheel at one tick: what the next plan starts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProfileState {
    /// Planned travel.
    pub position: Position,
    /// Planned velocity.
    pub velocity: Velocity,
}

/// What the controller of a wheel has to follow at one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Setpoint {
    /// Planned travel.
    pub travel: Travel,
    /// Planned speed.
    pub speed: Speed,
    /// Planned acceleration.
    pub acceleration: Acceleration,
}

/// Follows one plan after the other, tick by tick.
///
/// Two plans have their places here and are never moved: the one that is followed, and the one that waits.
#[derive(Clone, Debug)]
pub struct Profile {
    seats: [Seat; 2],
    /// The second seat's plan is followed, not the first one's.
    second: bool,
    /// The other seat's plan waits for its start.
    waiting: bool,
    /// The plan that is followed has come to its end, and its wheels stand for ever.
    ended: bool,
}

/// A plan, and how far the wheels have come on it.
#[derive(Clone, Debug)]
struct Seat {
    plan: Plan,
    walkers: WheelPair<Walker>,
}

impl Seat {
    #[inline]
    fn take(&mut self, plan: &Plan) {
        self.plan.clone_from(plan);
        self.walkers = WheelPair {
            left: Walker::new(&plan.courses.left),
            right: Walker::new(&plan.courses.right),
        };
    }
}

impl Profile {
    /// Stands still at the origin.
    pub const ORIGIN: Self = {
        const SEAT: Seat = Seat { plan: Plan::ORIGIN, walkers: WheelPair::both(Walker::ORIGIN) };
        Self { seats: [SEAT; 2], second: false, waiting: false, ended: false }
    };

    /// Follows `plan`; before its start it stands at the plan's first point.
    pub fn new(plan: Plan) -> Self {
        let mut profile = Self::ORIGIN;
        profile.replace(&plan);
        profile.go_over();
        profile
    }

    /// Goes over to `plan` at its start tick, or at once to a [`Plan::hold`]; until then the present
    /// one is followed.
    ///
    /// For a motion without a jump, plan from [`Profile::at`] the start tick. A plan that waits
    /// already is dropped.
    #[inline]
    pub fn replace(&mut self, plan: &Plan) {
        self.seats[usize::from(!self.second)].take(plan);
        self.waiting = true;
    }

    /// Goes over to the plan that waits, before its start: the wheels stand at its first point.
    pub const fn go_over(&mut self) {
        if self.waiting {
            self.second = !self.second;
            self.waiting = false;
            self.ended = false;
        }
    }

    /// Drops the plan that waits if its start is past: the wheels would jump. True if it did.
    pub fn drop_late(&mut self, tick: u32) -> bool {
        let next = &self.seats[usize::from(!self.second)].plan;
        let late = self.waiting && tick.wrapping_sub(next.start_tick()) as i32 > 0;
        self.waiting &= !late;
        late
    }

    /// State of both wheels at `tick`, now or later, as the plan that is followed now has it.
    #[inline]
    pub fn at(&self, tick: u32) -> WheelPair<ProfileState> {
        let plan = &self.seats[usize::from(self.second)].plan;
        plan.at(if self.ended { plan.end_tick() } else { tick })
    }

    /// The setpoints at `tick`. Cheapest when called at every tick; catches up if ticks were missed.
    #[inline(never)]
    pub fn step(&mut self, tick: u32) -> WheelPair<Setpoint> {
        if self.waiting {
            let next = &self.seats[usize::from(!self.second)].plan;
            if !next.has_start || reached(tick, next.start_tick()) {
                self.go_over();
            }
        }
        let Seat { plan, walkers } = &mut self.seats[usize::from(self.second)];
        let elapsed = if self.ended { plan.len_ticks() } else { plan.elapsed(tick) };
        // A plan is told from one that has not begun for 2^31 ticks only; standing still is for ever.
        self.ended = elapsed >= plan.len_ticks();
        walkers.left.walk(&plan.courses.left, elapsed);
        walkers.right.walk(&plan.courses.right, elapsed);
        WheelPair { left: walkers.left.setpoint(), right: walkers.right.setpoint() }
    }

    /// True if at `tick`, now or later, both wheels are at the target of the last plan given.
    #[inline(always)]
    pub fn finished(&self, tick: u32) -> bool {
        if !self.waiting && self.ended {
            return true;
        }
        let last = &self.seats[usize::from(self.second != self.waiting)].plan;
        !last.has_start || reached(tick, last.end_tick())
    }
}

/// True if `tick` is at most 2^31 ticks after `goal`.
fn reached(tick: u32, goal: u32) -> bool {
    tick.wrapping_sub(goal) as i32 >= 0
}
