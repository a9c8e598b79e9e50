//! What the picture shows.

use robot_model::{Geometry, OutAndBack, Pose, WheelWeight};

/// A calibration, ready to be drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationReport {
    /// What the robot's owner calls it.
    pub robot_name: String,
    /// Where it was found: `sim`, a serial device, an address.
    pub port: String,
    /// When, in words; `None` leaves it out, so that the same run gives the same bytes.
    pub date: Option<String>,
    /// The nominal robot.
    pub geometry: Geometry,
    /// The run that was driven twice.
    pub profile: ProfileNumbers,
    /// The run with the old wheel weight.
    pub before: RunReport,
    /// The run with the new one.
    pub after: RunReport,
    /// What an out-and-back run said, if there was one.
    pub out_and_back: Option<OutAndBack>,
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

/// One of the two runs. Frame: the line along which the robot set out; x along it, y to the left.
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
    /// What was read at the end.
    pub end: EndReading,
    /// What this run says W_T is.
    pub wheel_weight: WheelWeight,
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
            Self::Reckoned => "reckoned from the wheels' angles and the reading at the end",
        }
    }
}
