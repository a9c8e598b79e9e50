//! A wheel that turns the wrong way: is it the loop that drives it away?

use super::sample::{Positions, WheelSample};
use super::thresholds::WheelThresholds;
use crate::supply::SCALE_BITS;

/// A wheel rolled that was as fast as this before its count went the other way: 10 mm/s \[2^-24 m/tick\].
const ROLLS: i32 = 168;

/// A series of changes against the setpoint.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// Before its first change.
    start: Positions,
    /// At its first change.
    tick: u32,
    /// How fast the wheel was before it \[2^-24 m/tick\].
    speed: i32,
    /// Sum of the duty over its ticks \[2^-30\].
    push: i64,
    /// The wheel did not turn as the duty would have driven it the other way.
    pushed_by_hand: bool,
}

impl Run {
    /// `start`: before its first change, which came in this tick. `speed`: of the wheel before it \[2^-24 m/tick\].
    #[inline(always)]
    pub fn new(start: Positions, tick: u32, speed: i32) -> Self {
        Self { start, tick, speed, push: 0, pushed_by_hand: false }
    }

    /// One more tick; whether the wheel has gone far enough against its duty to be looked at.
    #[inline(always)]
    pub fn goes_on(&mut self, limits: &WheelThresholds, view: &WheelSample<'_>) -> bool {
        self.push += i64::from(view.duty().0.to_bits());
        let way = view.positions().travel.wrapping_sub(self.start.travel);
        way.unsigned_abs() >= limits.runaway as u32 / 2 && (self.push > 0) != (way > 0)
    }

    /// Whether the count goes the other way than the motor drives the wheel, of a run that [goes on](Self::goes_on).
    ///
    /// Two rules: the setpoint advanced, which needs no model of the motor; or the wheel went away from one that
    /// hardly moved, faster and faster, just as the feedforward's motor would.
    ///
    /// `supply_scale`: by which the duty was scaled for the supply. `lately`: how far the wheel has turned by its newest
    /// changes, and in how many ticks.
    pub fn runs_against_motor(
        &mut self,
        limits: &WheelThresholds,
        (view, supply_scale): (&WheelSample<'_>, i32),
        (tick, lately): (u32, (u32, u32)),
    ) -> bool {
        let moved = view.positions().since(self.start);
        let way = moved.travel.unsigned_abs();
        let ticks = i64::from(tick.wrapping_sub(self.tick));
        let at_supply = |nominal: i64| (nominal >> SCALE_BITS) * i64::from(supply_scale);
        let needed = limits.needed(way, lately, self.speed);
        let driven = Driven {
            by: self.push.abs(),
            least: at_supply(needed >> 1),
            most: at_supply((needed << 2) + limits.friction * ticks),
        };
        // By the first counts of a wheel that rolled on, its duty tells nothing yet.
        let tells = way >= limits.runaway as u32 || self.speed < ROLLS;
        self.pushed_by_hand |= tells && !driven.explains_travel();
        // A hand that pushes a wheel back which should advance is taken for it.
        let advanced = moved.setpoint.unsigned_abs() >= way >> 1
            && (moved.setpoint > 0) != (moved.travel > 0)
            && way >= limits.reversed_run as u32;
        // Half as fast again as on average: at an even acceleration it is twice as fast.
        let (turned, time) = lately;
        let speeds_up = 2 * i64::from(turned) * ticks >= 3 * i64::from(way) * i64::from(time);
        advanced || (way >= limits.runaway as u32 && speeds_up && !self.pushed_by_hand)
    }
}

/// What the motor did to a wheel, in duty times ticks \[2^-30\].
#[derive(Clone, Copy)]
struct Driven {
    /// By its duty.
    by: i64,
    /// At least, for the way and the speed that the wheel gained: with half the configured inertia and no friction, as in a
    /// gear that is run in.
    least: i64,
    /// At most: with four times the inertia, and all of the configured friction.
    most: i64,
}

impl Driven {
    /// The wheel moved as the motor would have driven it.
    fn explains_travel(self) -> bool {
        (self.least..=self.most).contains(&self.by)
    }
}
