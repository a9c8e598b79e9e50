//! The fit from its data to its result; the steps are in the files beside this one.

use super::error::TrackFitError;
use super::result::{FitOptions, TrackFit};
use super::run::Run;
use super::track::{Track, WheelAngles, validate};
use crate::kinematics::geometry::Geometry;

/// Fits W_T to a track and the wheel angles of the same run.
///
/// Samples outside the time of the wheel angles are left out.
pub fn fit_track(
    track: &Track,
    wheel_angles: &[WheelAngles],
    geometry: &Geometry,
    options: FitOptions,
) -> Result<TrackFit, TrackFitError> {
    validate(track, wheel_angles, geometry)?;
    let run = Run::new(track, wheel_angles, geometry, options)?;
    let beta = run.least_squares()?;
    run.with_uncertainty(beta)
}
