//! How well the wheels follow a profile, drive by drive.

use host_link::motion::{self, Motion, RecordOptions};
use host_link::session::Session;
use shared_proto::{Command, Config, Fault, State, Telemetry, TravelUnit, Wheel, WheelPair};

use super::floor::Floor;
use super::rest::{self, Rest};
use super::shortfall::Shortfall;
use crate::error::Result;

/// The paper's cruise and ramp, in turns of a wheel; the fast profile is so many times as fast.
const CRUISE_REV_S: f64 = 0.523;
const RAMP_REV_S2: f64 = 0.101;
const FAST: f64 = 5.0;
/// An error of so many counts, root mean square, is what a count hides, twice: 2 / sqrt(12).
const COUNTS_TOLD: f64 = 0.577;
/// Twice what a quiet supply's noise leaves \[m\].
const NOISE_M: f64 = 4e-5;

/// So near a wheel has arrived, or within two counts \[m\].
const SETTLED_M: f64 = 2e-4;

/// How well the wheels followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Following {
    /// Distance from the setpoint, root mean square over both wheels and all drives \[m\].
    pub rms_m: f64,
    /// The same of the fast drives.
    pub fast_rms_m: f64,
    /// The largest \[m\].
    pub worst_m: f64,
    /// How far a wheel went beyond its target, as a share of the drive.
    pub overshoot: f64,
    /// Longest time from a setpoint's arrival until the wheel stays within two counts and 0.2 mm of it \[s\].
    pub settling_s: f64,
    /// Change of the duty from frame to frame while cruising, root mean square.
    pub duty_noise: f64,
}

/// How far both wheels were from their setpoints, at one instant of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceSample {
    /// Since the drive began \[s\].
    pub t_s: f64,
    /// Setpoint less travel \[m\].
    pub error_m: WheelPair<f64>,
}

/// What came of the drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// All were driven.
    Followed(Following),
    /// The robot stopped with a fault.
    Faulted(Fault),
}

impl Following {
    /// Whether the robot follows better than before, or as well as its encoders can tell, without new oscillation.
    pub fn is_better_than(&self, before: &Outcome, meters_per_count: f64) -> bool {
        if self.overshoot > 0.05 || self.duty_noise > 0.1 {
            return false;
        }
        match before {
            Outcome::Followed(before) => {
                let told_m = COUNTS_TOLD * meters_per_count;
                self.fast_rms_m <= before.fast_rms_m.max(told_m)
            }
            Outcome::Faulted(_) => true,
        }
    }
}

impl Following {
    /// Whether the fast profile shows more than what counts and noise leave.
    pub fn is_loose(&self, meters_per_count: f64) -> bool {
        self.fast_rms_m > (COUNTS_TOLD * meters_per_count).max(NOISE_M)
    }
}

/// The paper's ramp for a wheel of this radius.
pub fn paper_acceleration_mps2(wheel_radius_m: f64) -> f64 {
    RAMP_REV_S2 * std::f64::consts::TAU * wheel_radius_m
}

/// One drive of a profile.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    /// Five times as fast as the paper's.
    pub is_fast: bool,
    /// Which way.
    pub forwards: bool,
}

/// The motion for a configuration on this floor: backwards at most to where the robot stood at first.
fn profile(config: &Config, floor: &Floor, drive: Drive) -> Motion {
    let times = if drive.is_fast { FAST } else { 1.0 };
    let back_m = if drive.forwards { f64::INFINITY } else { floor.at_m() };
    let room_m = (0.8 * floor.room_m(true)).min(back_m).max(0.05);
    let turn_m = std::f64::consts::TAU * config.geometry.wheel_radius_m;
    let motion = Motion {
        unit: TravelUnit::Meter,
        distance: WheelPair::both(room_m.min(3.0 * turn_m)),
        cruise: (times * CRUISE_REV_S * turn_m).min(0.9 * config.limits.speed_mps_max),
        acceleration: (times * times * RAMP_REV_S2 * turn_m)
            .min(0.9 * config.limits.acceleration_mps2_max),
    };
    if drive.forwards { motion } else { motion.reversed() }
}

/// Whether gains alone may have caused it. With the factory's gains on another motor that is any fault of a wheel; with constants
/// that were measured, a wheel that does not answer is a matter of hardware.
fn is_ours(fault: Fault, motors_known: bool) -> bool {
    let silent =
        matches!(fault, Fault::EncoderDead(_) | Fault::NoResponse(_) | Fault::EncodersExchanged(_));
    if motors_known && silent {
        return false;
    }
    matches!(
        fault,
        Fault::FollowingError(_)
            | Fault::Stall(_)
            | Fault::CountRate(_)
            | Fault::EncoderReversed(_)
            | Fault::EncoderDead(_)
            | Fault::NoResponse(_)
            | Fault::EncodersExchanged(_)
    )
}

/// Drives with one configuration.
#[derive(Clone, Default)]
pub struct Drives {
    /// Squares of the errors, and how many, of the slow drives and of the fast ones.
    errors: [(f64, f64); 2],
    worst_m: f64,
    overshoot: f64,
    duty_squares: f64,
    duty_count: f64,
    settling_s: f64,
    motors_known: bool,
    /// The first fast drive forwards.
    pub trace: Vec<TraceSample>,
    /// What the fast drives show.
    pub shortfall: Shortfall,
}

impl Drives {
    /// With settings made for this robot's motors; if `motors_known`, which takes short counts, a wheel that does not answer
    /// ends the tuning.
    pub fn for_identified_motors(motors_known: bool) -> Self {
        Self { motors_known, ..Self::default() }
    }

    /// Drives this one; a fault that gains alone may have caused is cleared and returned.
    pub async fn drive(
        &mut self,
        session: &mut Session,
        config: &Config,
        floor: &mut Floor,
        drive: Drive,
    ) -> Result<Option<Fault>> {
        let motion = profile(config, floor, drive);
        let mut telemetry = Vec::new();
        let options = RecordOptions::default();
        let mut rest = Rest::Stands;
        let driven =
            motion::drive_into(session, &motion, options, &mut telemetry, &mut |_| {}).await;
        if let Err(host_link::Error::Faulted(report)) = &driven
            && is_ours(report.fault, self.motors_known)
        {
            rest = rest::wait_until_wheels_stand(session, &mut telemetry).await?;
        }
        floor.follow(config, &telemetry);
        match driven {
            Ok(_) => {
                self.add(config, &motion, &telemetry, drive.is_fast);
                Ok(None)
            }
            Err(host_link::Error::Faulted(report)) if is_ours(report.fault, self.motors_known) => {
                session.request(Command::ClearFault { number: report.number }).await?;
                match rest {
                    Rest::Stands => Ok(Some(report.fault)),
                    Rest::Rolls => Err(rest::rolls_by_itself()),
                    Rest::CountsAlone(wheel) => Err(rest::counts_by_itself(wheel)),
                }
            }
            Err(error) => Err(error.into()),
        }
    }

    fn add(&mut self, config: &Config, motion: &Motion, telemetry: &[Telemetry], is_fast: bool) {
        // The encoder check leaves the wheels some counts ahead; the drive takes that back at its beginning.
        let driving: Vec<&Telemetry> = telemetry
            .iter()
            .filter(|frame| frame.state == State::Driving && !frame.probing)
            .collect();
        if is_fast {
            self.shortfall.add(config, &driving);
        }
        if is_fast && self.trace.is_empty() {
            self.trace = trace(&driving);
        }
        let settled = &driving[driving.len() / 3..];
        for wheel in Wheel::BOTH {
            let distance_m = *motion.distance.get(wheel);
            for frame in settled {
                let error_m = f64::from(frame.wheels.get(wheel).error_um) * 1e-6;
                let (squares, count) = &mut self.errors[usize::from(is_fast)];
                *squares += error_m * error_m;
                *count += 1.0;
                self.worst_m = self.worst_m.max(error_m.abs());
            }
            if let Some(last) = driving.last() {
                let target_um = last.wheels.get(wheel).setpoint_um;
                for frame in settled {
                    let wheel = frame.wheels.get(wheel);
                    let travel_um = wheel.setpoint_um - i64::from(wheel.error_um);
                    let beyond_m = (travel_um - target_um) as f64 * 1e-6 * distance_m.signum();
                    self.overshoot = self.overshoot.max(beyond_m / distance_m.abs());
                }
            }
            let count_m = config.meters_per_count(config.encoder.get(wheel));
            self.settling_s = self.settling_s.max(settling_s(&driving, wheel, count_m));
            let middle = &settled[settled.len() / 4..settled.len() / 2];
            for pair in middle.windows(2) {
                let duty = |frame: &Telemetry| f64::from(frame.wheels.get(wheel).duty) / 32767.0;
                let change = duty(pair[1]) - duty(pair[0]);
                self.duty_squares += change * change;
                self.duty_count += 1.0;
            }
        }
    }

    /// How well the wheels followed in all of them.
    pub fn following(&self) -> Following {
        let rms = |squares: f64, count: f64| (squares / count.max(1.0)).sqrt();
        let [slow, fast] = self.errors;
        Following {
            rms_m: rms(slow.0 + fast.0, slow.1 + fast.1),
            fast_rms_m: rms(fast.0, fast.1),
            worst_m: self.worst_m,
            overshoot: self.overshoot,
            settling_s: self.settling_s,
            duty_noise: (self.duty_squares / self.duty_count.max(1.0)).sqrt(),
        }
    }
}

fn trace(driving: &[&Telemetry]) -> Vec<TraceSample> {
    let first_us = driving.first().map_or(0, |first| first.t_us);
    let sample = |frame: &&Telemetry| TraceSample {
        t_s: frame.t_us.saturating_sub(first_us) as f64 * 1e-6,
        error_m: frame.wheels.map(|wheel| f64::from(wheel.error_um) * 1e-6),
    };
    driving.iter().map(sample).collect()
}

/// Time from a setpoint's arrival until the wheel stays near it \[s\].
fn settling_s(driving: &[&Telemetry], wheel: Wheel, count_m: f64) -> f64 {
    let Some(target_um) = driving.last().map(|last| last.wheels.get(wheel).setpoint_um) else {
        return 0.0;
    };
    let within_um = SETTLED_M.max(2.0 * count_m) * 1e6;
    let arrived = driving.iter().position(|frame| frame.wheels.get(wheel).setpoint_um == target_um);
    let Some(arrived) = arrived else { return 0.0 };
    let standing = &driving[arrived..];
    let off = |frame: &Telemetry| f64::from(frame.wheels.get(wheel).error_um).abs() > within_um;
    standing.iter().rposition(|frame| off(frame)).map_or(0.0, |last| {
        let until = standing.get(last + 1).unwrap_or(&standing[last]);
        until.t_us.saturating_sub(standing[0].t_us) as f64 * 1e-6
    })
}
