//! Trapezoidal motions of both wheels.
//!
//! # Accounting
//!
//! A [`Plan`] is made once, outside the control tick: ramp to a cruise speed, cruise, ramp to zero, for each
//! wheel in continuous time and double precision. Phases may begin between ticks, so neither distance nor
//! duration is rounded to whole ticks. For each phase the plan keeps position and velocity at the first tick
//! inside, in closed form. From there a tick is exact integer arithmetic:
//!
//! ```text
//! s(n) = s(0) + n v(0) + n^2 h,   v(n) = v(0) + 2 n h,   h half the acceleration    (1)
//! s <- s + v + h,   v <- v + 2 h                                                    (2), the same step by step
//! ```
//!
//! with s in 2^-64 m, v in 2^-64 m per tick and h in 2^-64 m per tick^2. Nothing is rounded inside a
//! phase, so nothing drifts, and a plan ends at its target to the last bit. Where two phases
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

/// Follows one plan after another, tick by tick.
///
/// Two slots hold the plan that is followed and the next plan. Neither is moved.
#[derive(Clone, Debug)]
pub struct Profile {
    slots: [Slot; 2],
    /// The second slot's plan is followed, not the first slot's.
    second: bool,
    /// The other slot's plan waits for its start.
    waiting: bool,
    /// The plan that is followed has ended: its wheels stand still for ever.
    ended: bool,
}

/// A plan, and the wheels' present points on their trajectories.
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

    /// Follows `plan`, and stands at the plan's first point before its start.
    pub fn new(plan: Plan) -> Self {
        let mut profile = Self::ORIGIN;
        profile.replace(&plan);
        profile.switch();
        profile
    }

    /// Switches to `plan` at its start tick, or at once to a [`Plan::hold`]. Until then the present plan is
    /// followed.
    ///
    /// For a motion without a jump, plan from [`Profile::at`] the start tick. A plan that is
    /// already waiting is dropped.
    #[inline]
    pub fn replace(&mut self, plan: &Plan) {
        self.slots[usize::from(!self.second)].take(plan);
        self.waiting = true;
    }

    /// Switches to the waiting plan before its start: the wheels stand at its first point.
    pub const fn switch(&mut self) {
        if self.waiting {
            self.second = !self.second;
            self.waiting = false;
            self.ended = false;
        }
    }

    /// Drops the waiting plan if its start has passed, because the wheels would jump. True if it was dropped.
    pub fn drop_late(&mut self, tick: u32) -> bool {
        let next = &self.slots[usize::from(!self.second)].plan;
        let late = self.waiting && tick.wrapping_sub(next.start_tick()) as i32 > 0;
        self.waiting &= !late;
        late
    }

    /// State of both wheels at `tick`, now or later, by the plan that is followed now.
    #[inline]
    pub fn at(&self, tick: u32) -> WheelPair<ProfileState> {
        let plan = &self.slots[usize::from(self.second)].plan;
        plan.at(if self.ended { plan.end_tick() } else { tick })
    }

    /// The setpoints at `tick`, by value.
    #[inline]
    pub fn setpoints(&mut self, tick: u32) -> WheelPair<Setpoint> {
        let mut setpoints = WheelPair::both(Setpoint::default());
        self.step(tick, &mut setpoints);
        setpoints
    }

    /// Writes the setpoints at `tick`. Cheapest when called at every tick; catches up if ticks were missed.
    #[inline(never)]
    pub fn step(&mut self, tick: u32, setpoints: &mut WheelPair<Setpoint>) {
        if self.waiting {
            let next = &self.slots[usize::from(!self.second)].plan;
            if !next.has_start || reached(tick, next.start_tick()) {
                self.switch();
            }
        }
        let Slot { plan, cursors } = &mut self.slots[usize::from(self.second)];
        let elapsed = if self.ended { plan.len_ticks() } else { plan.elapsed(tick) };
        // Tick numbers tell before from after for 2^31 ticks only; an ended plan must stay ended.
        self.ended = elapsed >= plan.len_ticks();
        cursors.left.advance_to(&plan.trajectories.left, elapsed);
        cursors.right.advance_to(&plan.trajectories.right, elapsed);
        setpoints.left = cursors.left.setpoint();
        setpoints.right = cursors.right.setpoint();
    }

    /// True if the tick before was at the end of the last plan given, or after it.
    #[inline(always)]
    pub const fn has_ended(&self) -> bool {
        self.ended && !self.waiting
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
