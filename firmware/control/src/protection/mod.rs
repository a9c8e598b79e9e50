//! Detects wheel and encoder faults while the loop is closed.
//!
//! # Rules
//!
//! With the setpoint's travel s and the measured s_m, for each wheel at every tick:
//!
//! | fault | when |
//! | --- | --- |
//! | `CountRate` | the count changes in one tick by more than 4 counts and 4 times the speed limit (0.1 m/s, where that is less) |
//! | `EncoderDead` | the count turns round 5 times, each time within a stall time of the last, by 0.2 mm in a tick, and not back to the count before |
//! | `EncoderDead` | the count turned round 5 times, each time within a stall time of the last, by any step (if a count is longer than 1 mm, not back to the count before), while the setpoint advanced by 4 counts and 2 mm, and the count by less than a quarter of that; after 16 turns, or half as far again, by less than half |
//! | `EncoderReversed` | the count has run against the setpoint for at least 6 counts (3 where 6 are more than a quarter of the permitted following error) and 15 % of that error, while the setpoint advanced half as far; a wheel that is ahead of its setpoint and driven back does not |
//! | `EncoderReversed` | the count has run against the setpoint, or away from one at rest, for at least 6 counts (or 3, as above) and 5 % of the permitted following error, faster and faster, and as far as the duty against it would have driven the wheel the other way, from the speed that it had |
//! | `EncoderDead`, `Stall`, `NoResponse` | the count stands for a stall time while the setpoint advances by 4 counts and 2 mm, and that far beyond the wheel |
//! | `EncoderDead`, `Stall`, `NoResponse` | the count stands while the motor's push, either way, would turn the wheel by 4 counts: at a duty of 0.05 and more above ks (0.1, if a count is longer than 0.5 mm), for 128 ms at least, while the setpoint moves and is a count and 0.5 mm further than at the last count, or the wheel a count and 2 mm from it |
//! | `EncoderDead`, `Stall`, `NoResponse` | within the last stall time the setpoint advanced by 8 counts and 4 mm, and the wheel by less than an eighth of that |
//! | `Stall` | the setpoint rests, or moves at less than 3.9 mm/s and does not speed up, and the wheel has stood for 2 stall times, 4 counts and 2 mm off, or for 10, a count and 0.25 mm off (4 counts, if a count is longer than 1 mm and goes to and fro), at a duty of 0.1 and more above ks, and as far from the integral that the loop had when the wheel last turned; or it is a count and 0.25 mm off, and was pushed half as long as in the rule of the motor's push, at such a duty of 0.05 (or 0.1) |
//! | `FollowingError` | the error is above its limit, and none of the above explains it |
//!
//! Duties are those at the nominal supply.
//!
//! A count that stops means a dead encoder if, through its last 2 counts and 4 ticks, the wheel ran at two
//! thirds of the setpoint's speed or more, and, compared with the setpoint, through the last two counts at three quarters
//! of its speed through the two before: a wheel has mass and slows down before it stands. Otherwise the wheel is stalled.
//! (A jam that stops a wheel within 2 counts looks like a dead wire.) Two kinds of counts tell neither: up to four since the
//! loop closed, and those of a wheel so slow that friction stops it within three counts (62 mm/s at 0.25 mm a count). Those
//! of a plug that is pulled and of a motor that loses a lead are the same there. That is `NoResponse`.
//!
//! By chance the count of an encoder with a floating line runs backwards for a while. So `EncoderReversed` waits until it has not
//! turned round for 16 ticks (32, if it has turned before), or three quarters of the permitted following error are used up.
//!
//! A count that goes back to what it was before its last change stands: an encoder with one line counts up and down.
//!
//! A slow setpoint takes long for 2 mm, so starting from rest and reversing raise no fault.

mod last_changes;
mod runaway;
mod sample;
mod thresholds;
mod wheel_fault;
mod wheel_monitor;

use shared_proto::{Config, Fault, WheelPair};

use crate::capture::Measured;
use crate::pid::PidState;
use crate::profile::Setpoint;

use sample::WheelSample;
pub use thresholds::{Thresholds, counts_per_tick_max};
use wheel_monitor::WheelMonitor;

/// Monitors both wheels.
#[derive(Clone, Debug)]
pub struct Protection {
    thresholds: Thresholds,
    monitors: WheelPair<WheelMonitor>,
    /// False until the first step.
    watching: bool,
    /// Which wheel is compared with its setpoint at this tick: one after the other, so that no tick has to compare both.
    left_is_due: bool,
}

impl Protection {
    /// A monitor that starts with the first step.
    #[inline]
    pub fn new(config: &Config) -> Self {
        Self::with(Thresholds::new(config))
    }

    /// A monitor with these thresholds that starts with the first step.
    pub const fn with(thresholds: Thresholds) -> Self {
        Self {
            thresholds,
            monitors: WheelPair::both(WheelMonitor::BLANK),
            watching: false,
            left_is_due: false,
        }
    }

    /// Restarts with the next step.
    pub const fn restart(&mut self) {
        self.watching = false;
    }

    /// What the wheels are compared with.
    pub const fn thresholds(&self) -> &Thresholds {
        &self.thresholds
    }

    /// Adopts new thresholds and restarts.
    pub fn adopt(&mut self, thresholds: &Thresholds) {
        self.thresholds.clone_from(thresholds);
        self.restart();
    }

    /// One tick; returns the first fault found, the left wheel's before the right wheel's.
    ///
    /// `loops`: both controllers after this tick. `supply_scale`: by which the duty was scaled for the supply, as in [`step_both`](crate::pid::step_both).
    #[inline(never)]
    pub fn step(
        &mut self,
        setpoints: &WheelPair<Setpoint>,
        measured: &Measured,
        loops: &WheelPair<PidState>,
        supply_scale: i32,
    ) -> Option<Fault> {
        let Measured { travel, counts, .. } = measured;
        let left = WheelSample {
            setpoint: &setpoints.left,
            travel: travel.left,
            counts: counts.left as u32,
            controller: &loops.left,
        };
        let right = WheelSample {
            setpoint: &setpoints.right,
            travel: travel.right,
            counts: counts.right as u32,
            controller: &loops.right,
        };
        if !self.watching {
            self.watching = true;
            let Thresholds(limits) = &self.thresholds;
            self.monitors.left.begin(&left, 0);
            self.monitors.right.begin(&right, limits.right.checkpoint_ticks / 2);
            return None;
        }
        self.left_is_due = !self.left_is_due;
        let (due, limits) = (self.left_is_due, &self.thresholds.0);
        let found = (
            self.monitors.left.step(&limits.left, left, supply_scale, due),
            self.monitors.right.step(&limits.right, right, supply_scale, !due),
        );
        match found {
            (None, None) => None,
            (left, right) => {
                let (wheel, fault) = WheelPair::new(left, right).first_some()?;
                Some(fault.of(wheel))
            }
        }
    }
}
