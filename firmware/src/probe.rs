//! The encoder check: the encoders' signs, tested at low power before the loop closes.
//!
//! With a reversed or a dead encoder, a closed loop runs away. So before a motion the check pushes each
//! wheel that is about to turn, in the direction of the motion and with the loop open. The duty rises
//! slowly from zero to `protection.probe_duty_max`. A wheel passes when its count has moved the right way
//! by 3 counts and 0.2 mm, in at least two changes; its duty then goes to zero while the other wheel
//! continues.
//!
//! # When the check fails
//!
//! The distance that a wheel should have rolled follows from the feedforward model,
//!
//! ```text
//! s = sum of max(0, duty - ks) / kv dt                                    (1)
//! ```
//!
//! and the check gives up at s = 5 mm, or when the largest duty was held for 7 stall times. No count
//! at all means a dead encoder, too few a stall, and counts the wrong way a reversed encoder.
//! The duty takes 0.8 s to rise, so no probe takes more than 0.8 s + 7 * 0.09 s.

use fixed::types::I2F30;
use shared_proto::{Config, Fault, Wheel, WheelPair};

use crate::odometry::Odometry;
use crate::soft_float::{is_above, max, min, nearest, truncate};
use crate::units::{CONTROL_HZ, Duty, MetersPerCount};

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

/// Time for the duty to rise from zero to the largest.
const RISE_TICKS: u32 = 8 * CONTROL_HZ / 10;
/// The largest duty is held for this many stall times before the probe gives up.
const HOLD_STALL_TIMES: f64 = 7.0;
/// Expected travel without enough counts at which the probe gives up \[m\]: half of the 10 mm that a
/// robot with an unplugged encoder may move, the rest being for rolling out and a weak model.
const EXPECTED_M_MAX: f64 = 0.005;
/// A coarse encoder is allowed the distance of this many counts, if that is longer.
const EXPECTED_COUNTS_MAX: f64 = 6.0;
/// Counts that tell a direction.
const COUNTS_MIN: f64 = 3.0;
/// Travel that tells a direction, against the backlash and shiver that fine encoders see \[m\].
const TRAVEL_M_MIN: f64 = 0.0002;
/// Changes of the count that tell a movement from one loose edge.
const CHANGES_MIN: u32 = 2;
/// No wheel of a robot rolls faster at full duty \[m/s\]; bounds (1) where kv is not configured.
const FULL_SPEED_MPS_MAX: f64 = 20.0;

/// The limits of one wheel's check.
#[derive(Clone, Copy, Debug)]
struct ProbeLimits {
    duty_max: i32,
    duty_rise_dt: i32,
    ks: i32,
    /// Of (1), as a sum of duties over ticks [2^-30].
    push_max: i64,
    hold_ticks: u32,
    counts: i64,
}

impl ProbeLimits {
    fn new(config: &Config, q: MetersPerCount) -> Self {
        let q_m = q.metres();
        let hz = f64::from(CONTROL_HZ);
        let bits = |duty: f64| nearest(duty, I2F30::FRAC_NBITS) as i32;
        let kv_s_per_m = max(config.feedforward.kv_s_per_m, 1.0 / FULL_SPEED_MPS_MAX);
        let expected_m = max(EXPECTED_M_MAX, EXPECTED_COUNTS_MAX * q_m);
        let duty_max = bits(min(config.protection.probe_duty_max, config.limits.duty_max));
        Self {
            duty_max,
            duty_rise_dt: (duty_max / RISE_TICKS as i32).max(1),
            ks: bits(config.feedforward.ks),
            push_max: truncate(expected_m * kv_s_per_m * hz, I2F30::FRAC_NBITS),
            hold_ticks: truncate(HOLD_STALL_TIMES * config.protection.stall_time_s * hz, 0) as u32,
            counts: truncate(max(COUNTS_MIN, TRAVEL_M_MIN / q_m), 0),
        }
    }
}

/// The state of one wheel's check.
#[derive(Clone, Copy, Debug)]
struct WheelProbe {
    limits: ProbeLimits,
    /// 1 or -1, or 0 once the wheel has passed.
    sign: i32,
    start: i64,
    last: i64,
    changes: u32,
    duty: i32,
    /// The sum in (1) so far.
    push: i64,
    held_ticks: u32,
}

impl WheelProbe {
    fn new(limits: ProbeLimits, counts: i64, direction: Direction) -> Self {
        let sign = match direction {
            Direction::Backward => -1,
            Direction::Still => 0,
            Direction::Forward => 1,
        };
        Self {
            limits,
            sign,
            start: counts,
            last: counts,
            changes: 0,
            duty: 0,
            push: 0,
            held_ticks: 0,
        }
    }

    /// One tick; returns the fault, if there is one.
    fn step(&mut self, counts: i64) -> Option<fn(Wheel) -> Fault> {
        if self.sign == 0 {
            return None;
        }
        let limits = &self.limits;
        if counts != self.last {
            self.last = counts;
            self.changes = self.changes.saturating_add(1);
        }
        let moved = counts.wrapping_sub(self.start).wrapping_mul(i64::from(self.sign));
        if self.changes >= CHANGES_MIN && moved >= limits.counts {
            self.sign = 0;
            self.duty = 0;
            return None;
        }
        if self.changes >= CHANGES_MIN && moved <= -limits.counts {
            return Some(Fault::EncoderReversed);
        }
        // (1), with the duty of the tick before
        self.push += i64::from((self.duty - limits.ks).max(0));
        if self.duty < limits.duty_max {
            self.duty = (self.duty + limits.duty_rise_dt).min(limits.duty_max);
        } else {
            self.held_ticks += 1;
        }
        if self.push < limits.push_max && self.held_ticks < limits.hold_ticks {
            None
        } else if self.changes == 0 {
            Some(Fault::EncoderDead)
        } else {
            Some(Fault::Stall)
        }
    }

    fn duty(&self) -> Duty {
        Duty(I2F30::from_bits(self.duty * self.sign))
    }
}

/// The probe of both wheels.
#[derive(Clone, Debug)]
pub struct Probe {
    wheels: WheelPair<WheelProbe>,
}

impl Probe {
    /// A probe that begins with the wheels at rest at `counts`.
    pub fn new(config: &Config, counts: WheelPair<i64>, directions: WheelPair<Direction>) -> Self {
        let limits = Odometry::new(config).meters_per_count().map(|q| ProbeLimits::new(config, q));
        Self {
            wheels: limits
                .zip(counts.zip(directions))
                .map(|(limits, (counts, direction))| WheelProbe::new(limits, counts, direction)),
        }
    }

    /// One tick, with the counts as they are now.
    pub fn step(&mut self, counts: WheelPair<i64>) -> ProbeOutcome {
        let wrong = WheelPair::new(
            self.wheels.left.step(counts.left),
            self.wheels.right.step(counts.right),
        );
        if let Some((wheel, fault)) = wrong.first_some() {
            ProbeOutcome::Failed(fault(wheel))
        } else if self.wheels.all(|wheel| wheel.sign == 0) {
            ProbeOutcome::Done
        } else {
            ProbeOutcome::Running(self.wheels.map(|wheel| wheel.duty()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const Q_M: f64 = core::f64::consts::TAU * 0.036 / 900.0;

    /// What is connected wrongly.
    #[derive(Clone, Copy, PartialEq)]
    enum Wiring {
        Sound,
        Unplugged,
        Reversed,
        Blocked,
        BlockedAfterOneCount,
    }

    /// A wheel that takes the speed of the feedforward model at once: as far as any gets.
    struct Bench {
        wiring: Wiring,
        travel_m: f64,
    }

    impl Bench {
        fn counts(&self) -> i64 {
            let counts = (self.travel_m / Q_M).round() as i64;
            match self.wiring {
                Wiring::Sound => counts,
                Wiring::Unplugged | Wiring::Blocked => 0,
                Wiring::Reversed => -counts,
                Wiring::BlockedAfterOneCount => counts.clamp(-1, 1),
            }
        }

        fn drive(&mut self, duty: f64) {
            if self.wiring != Wiring::Blocked {
                self.travel_m += duty.signum() * (duty.abs() - 0.04).max(0.0) / 2.0 / 1000.0;
            }
        }
    }

    /// Runs a probe; also tells its time in ticks and the farthest that a wheel got.
    fn probe(
        config: &Config,
        directions: WheelPair<Direction>,
        wirings: WheelPair<Wiring>,
    ) -> (ProbeOutcome, u32, f64) {
        let mut bench = wirings.map(|wiring| Bench { wiring, travel_m: 0.0 });
        let mut probe = Probe::new(config, WheelPair::both(0), directions);
        for tick in 0.. {
            let counts = WheelPair::new(bench.left.counts(), bench.right.counts());
            let outcome = probe.step(counts);
            let ProbeOutcome::Running(duty) = outcome else {
                let farthest_m = bench.left.travel_m.abs().max(bench.right.travel_m.abs());
                return (outcome, tick, farthest_m);
            };
            assert!(duty.all(|d| d.to_si().abs() <= config.protection.probe_duty_max));
            bench.left.drive(duty.left.to_si());
            bench.right.drive(duty.right.to_si());
        }
        unreachable!()
    }

    const AHEAD: WheelPair<Direction> = WheelPair::both(Direction::Forward);

    #[test]
    fn sound_encoders_pass_in_every_direction_within_a_millimetre_or_two() {
        use Direction::{Backward, Forward, Still};
        for (left, right) in
            [(Forward, Forward), (Backward, Backward), (Forward, Backward), (Still, Forward)]
        {
            let (outcome, ticks, farthest_m) = probe(
                &Config::default(),
                WheelPair::new(left, right),
                WheelPair::both(Wiring::Sound),
            );
            assert_eq!(outcome, ProbeOutcome::Done);
            // Edges lie half a count off the start: the third one at 2.5 counts, 0.6 mm.
            assert!((2.5 * Q_M..3.0 * Q_M).contains(&farthest_m), "{farthest_m}");
            assert!(ticks < 400, "{ticks}");
        }
    }

    #[test]
    fn a_wheel_that_will_stand_still_is_neither_pushed_nor_judged() {
        let (outcome, ticks, _) =
            probe(&Config::default(), WheelPair::default(), WheelPair::both(Wiring::Unplugged));
        assert_eq!((outcome, ticks), (ProbeOutcome::Done, 0));
    }

    #[test]
    fn each_wrong_wiring_is_named_before_10_mm_and_1500_ms_at_any_probe_duty() {
        for probe_duty_max in [0.02, 0.05, 0.1, 0.25, 0.5] {
            for stall_time_s in [0.01, 0.06, 0.09] {
                let mut config = Config::default();
                config.protection.probe_duty_max = probe_duty_max;
                config.protection.stall_time_s = stall_time_s;
                for (wiring, fault) in [
                    (Wiring::Unplugged, Fault::EncoderDead(Wheel::Right)),
                    (Wiring::Reversed, Fault::EncoderReversed(Wheel::Right)),
                    (Wiring::Blocked, Fault::EncoderDead(Wheel::Right)),
                    (Wiring::BlockedAfterOneCount, Fault::Stall(Wheel::Right)),
                ] {
                    // A probe this weak hardly turns the wheel, or not at all.
                    let weak = probe_duty_max < 0.1;
                    if weak && matches!(wiring, Wiring::Reversed | Wiring::BlockedAfterOneCount) {
                        continue;
                    }
                    let wirings = WheelPair::new(Wiring::Sound, wiring);
                    let directions = WheelPair::new(Direction::Still, Direction::Forward);
                    let (outcome, ticks, farthest_m) = probe(&config, directions, wirings);
                    assert_eq!(
                        outcome,
                        ProbeOutcome::Failed(fault),
                        "{probe_duty_max} {stall_time_s}"
                    );
                    // 5 mm by the model; rolling out takes the plant 2 mm more at most.
                    assert!(farthest_m < 0.0051 && ticks <= 1500, "{farthest_m} {ticks}");
                }
            }
        }
    }

    #[test]
    fn one_unplugged_encoder_is_found_although_the_other_one_passes() {
        let wirings = WheelPair::new(Wiring::Unplugged, Wiring::Sound);
        let (outcome, ticks, _) = probe(&Config::default(), AHEAD, wirings);
        assert_eq!(outcome, ProbeOutcome::Failed(Fault::EncoderDead(Wheel::Left)));
        assert!((100..600).contains(&ticks), "{ticks}");
    }

    #[test]
    fn one_loose_edge_is_not_taken_for_a_movement() {
        let mut probe = Probe::new(&Config::default(), WheelPair::both(0), AHEAD);
        // One jump of many counts: a single change.
        for _ in 0..50 {
            assert!(matches!(probe.step(WheelPair::both(40)), ProbeOutcome::Running(_)));
        }
        assert_eq!(probe.step(WheelPair::both(41)), ProbeOutcome::Done);
    }
}
