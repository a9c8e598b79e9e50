//! The data that the picture shows.

use std::fmt;

use robot_model::calibration::track_fit::Estimate;
use robot_model::calibration::wheel_weight::SIGMAS_95;
use robot_model::calibration::{CurvatureCause, OutAndBack, WheelWeight};
use robot_model::kinematics::{Geometry, Pose};

/// A calibration, ready to be drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationReport {
    /// The robot's name.
    pub robot_name: String,
    /// Its port: `sim`, a serial device, an address.
    pub port: String,
    /// The nominal robot.
    pub geometry: Geometry,
    /// The motion of every drive.
    pub profile: ProfileNumbers,
    /// The run with the old wheel weight.
    pub before: RunReport,
    /// The run with the new one.
    pub after: RunReport,
    /// The result of an out-and-back, if there was one.
    pub out_and_back: Option<OutAndBack>,
    /// The W_T that was written.
    pub wheel_weight: Estimate,
    /// The runs on which it is based.
    pub basis: Basis,
    /// How often the robot drove.
    pub drives: u32,
}

impl CalibrationReport {
    /// The headline.
    pub(crate) fn claim(&self) -> &'static str {
        if self.after.is_straighter_than(&self.before, 0.0) {
            "Drives straight"
        } else if self.out_and_back.is_some_and(|both| both.verdict == CurvatureCause::Both) {
            "Wheels corrected, a pull remains"
        } else {
            "Not straighter yet"
        }
    }
}

/// The runs on which a W_T is based.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// One run.
    OneRun,
    /// The mean of this many runs.
    Mean(u16),
    /// A run and the way back.
    BothWays,
}

impl fmt::Display for Basis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OneRun => f.write_str("one run"),
            Self::Mean(runs) => write!(f, "the mean of {runs} runs"),
            Self::BothWays => {
                f.write_str("the part of the curvature that changes sign between out and back")
            }
        }
    }
}

/// The commanded run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileNumbers {
    /// Acceleration of the wheels \[rev/s^2\].
    pub acceleration_rev_per_s2: f64,
    /// Cruise speed of the wheels \[rev/s\].
    pub cruise_rev_per_s: f64,
    /// Distance \[m\].
    pub distance_m: f64,
    /// How long it took \[s\].
    pub duration_s: f64,
}

/// One of the two runs. The frame is the start line: x along it, y to the left.
#[derive(Clone, Debug, PartialEq)]
pub struct RunReport {
    /// The wheel weight with which the robot drove.
    pub driven_with: f64,
    /// The path, drawn as a line.
    pub path: Vec<Pose>,
    /// Where the path comes from.
    pub path_source: PathSource,
    /// Measured points (x, y) \[m\], drawn as dots; may be empty.
    pub points_m: Vec<(f64, f64)>,
    /// The reading at the end.
    pub end: EndReading,
    /// The W_T that follows from this run.
    pub wheel_weight: WheelWeight,
}

impl RunReport {
    /// The distance between start and end \[m\].
    pub fn length_m(&self) -> f64 {
        let ends = self.path.first().zip(self.path.last());
        ends.map_or(0.0, |(start, end)| (end.x_m - start.x_m).hypot(end.y_m - start.y_m))
    }

    /// Whether this run was straighter than one before it: its turn is at most half as large, or
    /// not significant (95 %). `pull_alpha_rad` is the turn by a pull, which is in both runs.
    pub fn is_straighter_than(&self, before: &Self, pull_alpha_rad: f64) -> bool {
        let turn_rad = |run: &Self| (run.wheel_weight.alpha_rad - pull_alpha_rad).abs();
        let noise_rad = SIGMAS_95 * self.wheel_weight.alpha_sigma_rad;
        // A turn that is not significant may still be larger than the one before.
        turn_rad(self) < turn_rad(before)
            && turn_rad(self) <= (turn_rad(before) / 2.0).max(noise_rad)
    }
}

/// Where a drawn path comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathSource {
    /// Fitted to the points measured along the way.
    Measured,
    /// Reckoned from the wheels' angles and the reading at the end.
    Reckoned,
}

/// The reading at the end of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndReading {
    /// Distance from the line, to the left positive \[m\].
    pub lateral_offset_m: f64,
    /// Its standard uncertainty \[m\].
    pub lateral_offset_sigma_m: f64,
    /// Heading relative to the line, counter-clockwise positive \[rad\].
    pub heading_rad: f64,
    /// Its standard uncertainty \[rad\].
    pub heading_sigma_rad: f64,
}

impl PathSource {
    /// In words.
    pub const fn sentence(self) -> &'static str {
        match self {
            Self::Measured => "fitted to the points measured along the way",
            Self::Reckoned => "dead reckoning from the wheel angles, ending at the reading",
        }
    }
}
