//! One run as it was recorded: wheel angles, measured poses, a yaw rate sensor, each at its own times.

use core::f64::consts::TAU;
use core::fmt;

use serde::Serialize;

use crate::kinematics::wheel_pair::WheelPair;

/// A robot as its data sheet describes it: all effects are relative to this.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Robot {
    /// Nominal radius of both wheels, R \[m\].
    pub wheel_radius_m: f64,
    /// Nominal distance between the wheels' contact points, b \[m\].
    pub track_width_m: f64,
    /// Encoder revolutions per wheel revolution, 1/g.
    pub gear_reduction: f64,
    /// Angle of a wheel that one encoder count stands for \[rad\].
    pub rad_per_count: f64,
    /// Noise of the measured position, each coordinate \[m\]; `None`: to be estimated.
    pub position_sigma_m: Option<f64>,
    /// Noise of the measured heading \[rad\]; `None`: to be estimated.
    pub heading_sigma_rad: Option<f64>,
}

impl Robot {
    /// The paper's robot: R = 3.6 cm, b = 37.2 cm, 900 counts per turn of a wheel. Its noise is to be estimated.
    pub const PAPER: Self = Self {
        wheel_radius_m: 0.036,
        track_width_m: 0.372,
        gear_reduction: 1.0,
        rad_per_count: TAU / 900.0,
        position_sigma_m: None,
        heading_sigma_rad: None,
    };

    /// Standard deviation of a wheel's travel by the rounding to whole counts, before and after it \[m\].
    pub(crate) fn rounding_m(&self) -> f64 {
        self.wheel_radius_m * self.rad_per_count / 6.0_f64.sqrt()
    }
}

/// The wheels at one time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WheelSample {
    /// Time \[s\].
    pub t_s: f64,
    /// How far each wheel turned by its encoder, phi, any zero \[rad\].
    pub phi_rad: WheelPair<f64>,
}

/// The pose as a camera, a tracker or a person measured it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PoseMeasurement {
    /// Time by the sensor's clock \[s\].
    pub t_s: f64,
    /// x and y in a fixed frame \[m\].
    pub position_m: Option<[f64; 2]>,
    /// Heading, wrapped or not \[rad\].
    pub heading_rad: Option<f64>,
}

/// The yaw rate sensor at one time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GyroSample {
    /// Time \[s\].
    pub t_s: f64,
    /// Yaw rate, counter-clockwise positive \[rad/s\].
    pub rate_rad_s: f64,
}

/// One run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Recording {
    /// Its name.
    pub name: String,
    /// When it began, on one clock for the whole campaign \[s\].
    pub started_s: Option<f64>,
    /// Load on board \[kg\].
    pub payload_kg: f64,
    /// Held out: nothing is fitted to it or chosen by it, it only shows what a model predicts.
    pub held_out: bool,
    /// The wheels, times strictly increasing, at least two.
    pub wheels: Vec<WheelSample>,
    /// The measured poses, times strictly increasing.
    pub measured_poses: Vec<PoseMeasurement>,
    /// The yaw rate sensor, times strictly increasing.
    pub gyro: Vec<GyroSample>,
}

/// Why a recording cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordingError {
    /// The run.
    pub run: String,
    /// What is wrong with it.
    pub problem: RecordingProblem,
}

/// What is wrong with a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordingProblem {
    /// The campaign has no run.
    NoRuns,
    /// All runs are held out.
    AllHeldOut,
    /// The encoders were sampled less than twice.
    TooFewSamples,
    /// A number is not finite.
    NotFinite,
    /// Time does not increase.
    TimeNotIncreasing,
}

impl fmt::Display for RecordingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

impl core::error::Error for RecordingError {}

impl Recording {
    /// Refuses what cannot be computed with.
    pub fn validate(&self) -> Result<(), RecordingError> {
        let fail = |problem| Err(RecordingError { run: self.name.clone(), problem });
        if self.wheels.len() < 2 {
            return fail(RecordingProblem::TooFewSamples);
        }
        let finite = self.wheels.iter().all(|sample| {
            sample.t_s.is_finite()
                && sample.phi_rad.left.is_finite()
                && sample.phi_rad.right.is_finite()
        }) && self.measured_poses.iter().all(|pose| {
            let position = pose.position_m.unwrap_or_default();
            [pose.t_s, position[0], position[1], pose.heading_rad.unwrap_or_default()]
                .into_iter()
                .all(f64::is_finite)
        }) && self
            .gyro
            .iter()
            .all(|sample| sample.t_s.is_finite() && sample.rate_rad_s.is_finite())
            && self.payload_kg.is_finite()
            && self.started_s.unwrap_or_default().is_finite();
        if !finite {
            return fail(RecordingProblem::NotFinite);
        }
        let increasing = self.wheels.is_sorted_by(|a, b| a.t_s < b.t_s)
            && self.measured_poses.is_sorted_by(|a, b| a.t_s < b.t_s)
            && self.gyro.is_sorted_by(|a, b| a.t_s < b.t_s);
        if !increasing {
            return fail(RecordingProblem::TimeNotIncreasing);
        }
        Ok(())
    }

    /// How long it took \[s\].
    pub fn duration_s(&self) -> f64 {
        match (self.wheels.first(), self.wheels.last()) {
            (Some(first), Some(last)) => last.t_s - first.t_s,
            _ => 0.0,
        }
    }

    /// The wheel angles at a time, linear between samples, constant outside.
    pub(crate) fn phi_at(&self, t_s: f64) -> WheelPair<f64> {
        let after = self.wheels.partition_point(|sample| sample.t_s <= t_s);
        if after == 0 {
            return self.wheels[0].phi_rad;
        }
        let before = self.wheels[after - 1];
        let Some(next) = self.wheels.get(after) else {
            return before.phi_rad;
        };
        let share = (t_s - before.t_s) / (next.t_s - before.t_s);
        before.phi_rad.zip(next.phi_rad).map(|(a, b)| a + share * (b - a))
    }
}
