//! What a run comes to once somebody was asked to measure it.

use std::path::Path;

use robot_model::calibration::TrackSample;

use super::align::{Reckoned, shift_s};
use crate::error::Error;

/// What to do with a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Go {
    /// Drive it.
    Drive,
    /// Leave it out this time.
    Skip,
}

/// What was measured of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Seen {
    /// Poses on the robot's clock; none if nothing was measured.
    Track(Vec<TrackSample>),
    /// The run is to be driven again, and this one forgotten.
    Repeat,
    /// The run is to be left out.
    Skip,
}

/// How well a pose is measured, one sigma.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sigma {
    /// Of x and y \[m\].
    pub position_m: f64,
    /// Of the heading \[rad\].
    pub heading_rad: f64,
}

impl Sigma {
    /// A tape to the mark under the axle, and the robot's side against a line.
    pub const TAPE: Self = Self { position_m: 0.002, heading_rad: 0.01 };
}

/// The user wants no more for now.
pub(super) fn stopped() -> Error {
    Error::interrupted("stopped; the same command goes on from here")
}

pub(super) fn no_shift(path: &Path) -> Error {
    Error::new(format_args!("{} and the wheels have no motion in common", path.display()))
        .hint("is it the track of this run?")
}

/// A track by another clock, on the robot's. A track of a robot that stood still is put over the
/// telemetry as it is: there is no motion to go by, and none is needed.
pub(super) fn on_robot_clock(
    mut samples: Vec<TrackSample>,
    reckoned: &[Reckoned],
) -> Option<Vec<TrackSample>> {
    let moved = |poses: &[Reckoned]| {
        poses.iter().any(|it| {
            let (a, b) = (it.pose, poses[0].pose);
            (a.x_m - b.x_m).hypot(a.y_m - b.y_m) > 0.02
                || (a.heading_rad - b.heading_rad).abs() > 0.05
        })
    };
    let shift_s = if moved(reckoned) {
        shift_s(&samples, reckoned)?
    } else {
        reckoned.first()?.t_s - samples.first()?.t_s
    };
    samples.iter_mut().for_each(|it| it.t_s += shift_s);
    Some(samples)
}
