//! Options and result of a fit to a track.

use crate::calibration::wheel_weight::weight::WheelWeight;
use crate::kinematics::pose::Pose;

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

/// The result of a fit to a track.
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
    /// Scale of both wheel radii, relative to the nominal left radius and W_T.
    pub scale: Estimate,
    /// Sigma of W_T from the noise of the track alone.
    pub white_sigma: f64,
    /// Sigma of W_T with random wandering of the heading, which integrates along the run.
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
