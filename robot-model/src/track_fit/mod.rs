//! W_T from a whole measured track.
//!
//! The path that the wheel angles predict (exact arcs, radius and track width as given) is laid on
//! the measured points by weighted least squares. Unknown are W_T, the pose at the first sample
//! (always a nuisance, never evidence), a common scale of both radii (a nuisance too: else the length
//! of the track, which says as much of the tolerance of R as of W_T, would pass for evidence) and, if
//! asked for, the delay of the track's clock.
//!
//! **How sure.** Points of a track are not independent evidence of W_T: what bends the real path,
//! beyond the wheels, stays in every later point. So the path is also allowed to wander, by as much
//! as the track itself tells. The equations, numbered (1) to (9), and what they achieve stand in
//! `docs/how-sure-is-w-t.md`.

mod average;
mod end;
mod error;
mod judge;
mod residuals;
mod run;
mod scatter;
#[cfg(test)]
mod tests;
mod track;
mod wander;

use crate::geometry::Geometry;
use crate::path::Pose;
use crate::wheel_weight::WheelWeight;

pub use error::TrackFitError;
use run::Run;
use track::validate;
pub use track::{Track, TrackSample, WheelAngles};

/// What to fit besides W_T and the start pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FitOptions {
    /// A constant delay of the track's clock behind the wheels' clock.
    pub delay: bool,
}

/// A value and its standard uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard uncertainty.
    pub sigma: f64,
}

/// What a track says.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackFit {
    /// W_T, with everything in its sigma; its alpha is that of the whole run.
    pub wheel_weight: WheelWeight,
    /// Pose at the first sample, fitted.
    pub start: Pose,
    /// Pose at the last sample as fitted, in the frame of the start: `y_m` is the lateral offset.
    pub end: Pose,
    /// Standard uncertainty of the end's `y_m` \[m\].
    pub end_offset_sigma_m: f64,
    /// Standard uncertainty of the end's heading \[rad\].
    pub end_heading_sigma_rad: f64,
    /// Delay of the track \[s\], if it was fitted.
    pub delay_s: Option<Estimate>,
    /// Mean of both wheel radii relative to what the nominal left radius and W_T make it.
    pub scale: Estimate,
    /// Sigma of W_T if the track's noise were all there is.
    pub white_sigma: f64,
    /// Sigma of W_T with the robot's own wandering, which integrates.
    pub wander_sigma: f64,
    /// Root mean square of the position residuals without wandering, each axis \[m\].
    pub position_rms_m: f64,
    /// Root mean square of the heading residuals \[rad\]; zero without headings.
    pub heading_rms_rad: f64,
    /// Root mean square of the residuals in units of their sigmas; 1 if the noise is as stated.
    pub chi: f64,
    /// The fitted pose at each sample, in the frame of the track.
    pub fitted: Vec<Pose>,
}

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
    run.judge(beta)
}
