//! The encoder check: wiring and signs, tested at low power before the loop closes.
//!
//! With a reversed, exchanged or dead encoder, a closed loop runs away. So before a motion the check pushes
//! each wheel that is about to turn, one after the other, in the direction of the motion and with the loop
//! open. The duty rises slowly from half of kS. A wheel passes when its count has moved the right way by
//! 3 counts and 0.2 mm, in at least two changes; its duty then goes to zero, and when both wheels have
//! come to rest the other one is pushed.
//!
//! # When the check fails
//!
//! The distance that a wheel should have rolled follows from the feedforward model,
//!
//! ```text
//! s  = sum of w / kV dt                                                   (1)
//! w <- w + (max(0, duty - kS) - w) dt kV / kA                             (2)
//! ```
//!
//! with kS, in the push's direction, kV and kA as shares of the nominal supply: a heavy robot lags behind its duty.
//!
//! At s = 1.4 mm a robot with the friction of the model has passed. One with more friction may not have
//! moved at all, so the duty now rises fast to `protection.probe_duty_max`. The push ends when s
//! and what the wheel rolls on, braked by motor and friction, make 6.8 mm, or
//! when the largest duty was held for 7 stall times; then the wheel may roll out. No count at all, or too few, is
//! `NoResponse`: motor, wheel or encoder. A count that goes up and down by one means a dead encoder, counts the wrong way a
//! reversed encoder, and counts of the other wheel exchanged encoders (or motors: electrically that is the same).
//!
//! A count that twice changes in one tick by more than the wheel can turn is interference (`CountRate`), whatever
//! else it does. Such a change tells nothing else.
//!
//! Wheels that still roll, as from a drive that was cut short, are waited for, up to 3 s. The motion then begins where they stand.
//!
//! What the check cannot see: a wheel whose motor and encoder are both reversed, and left and right
//! exchanged together with their motors. Each wheel then follows its own count, so nothing runs away, but
//! the robot drives in mirror image.

mod wheel;

#[cfg(test)]
mod tests;

use shared_proto::{Config, Fault, Wheel, WheelPair};

use crate::odometry::Odometry;
use crate::soft_float::is_above;
use crate::units::Duty;
use wheel::{Push, PushLimits, RateWatch, WheelProbe};

/// Which way a wheel is about to turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Direction {
    /// Backwards.
    Backward,
    /// Not at all; the wheel is not probed.
    #[default]
    Still,
    /// Forwards.
    Forward,
}

impl Direction {
    /// 1, -1, or 0.
    fn sign(self) -> i32 {
        match self {
            Direction::Backward => -1,
            Direction::Still => 0,
            Direction::Forward => 1,
        }
    }

    /// The sign of a distance.
    pub fn of(distance: f64) -> Self {
        if !is_above(distance.abs(), 0.0) {
            Direction::Still
        } else if distance.is_sign_negative() {
            Direction::Backward
        } else {
            Direction::Forward
        }
    }
}

/// What the check found at one tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ProbeOutcome {
    /// Under way; apply these duties.
    Running(WheelPair<Duty>),
    /// Every wheel that is about to turn counts the way its motor pushes. Duty is zero.
    Done,
    /// Something is wrong; go to zero duty.
    Failed(Fault),
}

/// A wheel that has passed and rolls on without a brake is waited for this long \[ticks\].
const ROLL_OUT_TICKS_MAX: u32 = 300;
/// A wheel that rolls when the check begins is waited for this long \[ticks\]: from 0.6 m/s, at the 0.2 m/s^2 by which the
/// robot with the least friction and the largest load slows down without a brake.
const ROLLING_TICKS_MAX: u32 = 3_000;

/// Of a count: within a check it changes by far less than its lower half holds.
fn lower_half(count: i64) -> i32 {
    count as i32
}

/// The probe of both wheels.
#[derive(Clone, Debug)]
pub struct Probe {
    limits: WheelPair<PushLimits>,
    directions: WheelPair<Direction>,
    stage: Stage,
    rates: WheelPair<RateWatch>,
    /// Both counts must stand still this long before a wheel is pushed \[ticks\].
    quiet_ticks: u32,
}

#[derive(Clone, Debug)]
enum Stage {
    /// This wheel is next, once both counts stand still.
    Before { wheel: Wheel, last: WheelPair<i32>, still_ticks: u32, ticks_left: u32 },
    /// This wheel is pushed.
    Pushing { wheel: Wheel, probe: WheelProbe },
    /// Both wheels have passed.
    Done,
}

impl Probe {
    /// A probe that begins with the wheels at `counts`, and waits for them to come to rest if one is `rolling`.
    pub fn new(
        config: &Config,
        counts: WheelPair<i64>,
        directions: WheelPair<Direction>,
        rolling: bool,
    ) -> Self {
        let counts = counts.map(lower_half);
        let q = Odometry::new(config).meters_per_count();
        let limits = |wheel, q| PushLimits::new(config, wheel, directions.get(wheel).sign(), q);
        let limits =
            WheelPair { left: limits(Wheel::Left, q.left), right: limits(Wheel::Right, q.right) };
        let stage = Stage::Before {
            wheel: Wheel::Left,
            last: counts,
            still_ticks: 0,
            ticks_left: if rolling { ROLLING_TICKS_MAX } else { 0 },
        };
        let rates = counts.zip(limits).map(|(count, limits)| RateWatch::new(limits, count));
        let quiet_ticks = limits.left.quiet_ticks.max(limits.right.quiet_ticks);
        Self { limits, directions, stage, rates, quiet_ticks }
    }

    /// No wheel has been pushed yet.
    pub fn waits(&self) -> bool {
        matches!(self.stage, Stage::Before { wheel: Wheel::Left, .. })
    }

    /// One tick, with the counts as they are now.
    pub fn step(&mut self, counts: WheelPair<i64>) -> ProbeOutcome {
        let counts = counts.map(lower_half);
        let jumps = self.rates.as_mut().zip(counts).map(|(rate, count)| rate.jump(count));
        if jumps.any(|jump| jump != 0)
            && let Some(fault) = self.jumped(jumps)
        {
            return ProbeOutcome::Failed(fault);
        }
        loop {
            match &mut self.stage {
                Stage::Done => return ProbeOutcome::Done,
                Stage::Before { wheel, last, still_ticks, ticks_left } => {
                    if *still_ticks < self.quiet_ticks && *ticks_left > 0 {
                        *ticks_left -= 1;
                        *still_ticks = if counts == *last { *still_ticks + 1 } else { 0 };
                        *last = counts;
                        return ProbeOutcome::Running(WheelPair::both(Duty::ZERO));
                    }
                    let (wheel, start) = (*wheel, *last);
                    self.begin(wheel, start);
                }
                Stage::Pushing { wheel, probe } => {
                    let wheel = *wheel;
                    match probe.step(
                        self.limits.get(wheel),
                        *counts.get(wheel),
                        *counts.get(wheel.other()),
                    ) {
                        Push::Running(duty) => {
                            let mut duties = WheelPair::both(Duty::ZERO);
                            *duties.get_mut(wheel) = duty;
                            return ProbeOutcome::Running(duties);
                        }
                        Push::Failed(fault) => return ProbeOutcome::Failed(fault(wheel)),
                        Push::Passed => self.stage = self.after(wheel, counts),
                    }
                }
            }
        }
    }

    /// Counts jumped. Interference, unless it was once.
    #[cold]
    fn jumped(&mut self, jumps: WheelPair<i32>) -> Option<Fault> {
        match &mut self.stage {
            Stage::Before { last, .. } => {
                *last = last.zip(jumps).map(|(count, jump)| count.wrapping_add(jump));
            }
            Stage::Pushing { wheel, probe } => {
                probe.shift(*jumps.get(*wheel), *jumps.get(wheel.other()));
            }
            Stage::Done => {}
        }
        let fast = Wheel::BOTH.into_iter().find(|wheel| self.rates.get(*wheel).is_too_fast());
        fast.map(Fault::CountRate)
    }

    /// Pushes a wheel, unless it is to stand still.
    fn begin(&mut self, wheel: Wheel, counts: WheelPair<i32>) {
        self.stage = match self.directions.get(wheel).sign() {
            0 => match wheel {
                Wheel::Left => Stage::Before {
                    wheel: Wheel::Right,
                    last: counts,
                    still_ticks: 0,
                    ticks_left: 0,
                },
                Wheel::Right => Stage::Done,
            },
            sign => {
                let (own, other) = (*counts.get(wheel), *counts.get(wheel.other()));
                let limits = self.limits.get(wheel);
                let other_counts = self.limits.get(wheel.other()).other_counts;
                Stage::Pushing {
                    wheel,
                    probe: WheelProbe::new(limits, sign, own, other, other_counts),
                }
            }
        };
    }

    /// What follows when a wheel has passed.
    fn after(&self, wheel: Wheel, counts: WheelPair<i32>) -> Stage {
        if wheel == Wheel::Right || self.directions.right == Direction::Still {
            return Stage::Done;
        }
        Stage::Before {
            wheel: Wheel::Right,
            last: counts,
            still_ticks: 0,
            ticks_left: ROLL_OUT_TICKS_MAX,
        }
    }
}
