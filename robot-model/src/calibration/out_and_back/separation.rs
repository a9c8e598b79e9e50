//! Which part of two deviation angles is the radius, and which is a pull? Equations (1) and (2).

use core::fmt;

use crate::calibration::wheel_weight::error::WheelWeightError;
use crate::kinematics::geometry::Geometry;
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::distributions::SIGMAS_95;

/// One of the two runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Deviation angle over the run, **clockwise positive** \[rad\].
    pub alpha_rad: f64,
    /// Its standard uncertainty, without the tolerances of the nominal robot \[rad\].
    pub alpha_sigma_rad: f64,
    /// How far the wheels turned; negative angles backwards. Where a track shows the length of the path: how far
    /// wheels of the nominal radius would have turned for it.
    pub turns: WheelPair<f64>,
}

/// What the angles of the two runs have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shared {
    /// Covariance of the two alphas \[rad^2\].
    pub alpha_covariance_rad2: f64,
    /// How the runs were measured.
    pub measured_by: MeasuredBy,
}

impl Shared {
    /// Two tracks, measured independently.
    pub const TRACKS: Self = Self { alpha_covariance_rad2: 0.0, measured_by: MeasuredBy::Track };
}

/// How a run was measured: this decides how a wrong wheel radius acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasuredBy {
    /// A track: the turn and the length of the path.
    Track,
    /// Only the turn; the length is the nominal one.
    Angle,
    /// An offset from the line, converted to an angle with the nominal length.
    Offset,
}

impl MeasuredBy {
    /// n of (2).
    const fn radius_power(self) -> f64 {
        match self {
            Self::Track => 0.0,
            Self::Angle => 1.0,
            Self::Offset => 2.0,
        }
    }
}

/// The cause that bends the path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurvatureCause {
    /// The curvature flips: unequal radii, and nothing else beyond noise.
    Radius,
    /// The curvature does not flip: a pull.
    Pull,
    /// Both are beyond noise.
    Both,
    /// Neither is beyond noise.
    Neither,
}

impl CurvatureCause {
    /// By which of the two is beyond noise.
    const fn of(radius: bool, pull: bool) -> Self {
        match (radius, pull) {
            (true, true) => Self::Both,
            (true, false) => Self::Radius,
            (false, true) => Self::Pull,
            (false, false) => Self::Neither,
        }
    }
}

/// The result of a run out and a run back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutAndBack {
    /// W_T from the part that flips.
    pub wheel_weight: f64,
    /// Its standard uncertainty.
    pub wheel_weight_sigma: f64,
    /// The part of the forward run's alpha that flips, A \[rad\], clockwise positive.
    pub radius_alpha_rad: f64,
    /// Its standard uncertainty \[rad\].
    pub radius_alpha_sigma_rad: f64,
    /// The part that does not flip, per metre driven \[rad/m\], clockwise positive.
    pub pull_rad_per_m: f64,
    /// Its standard uncertainty \[rad/m\].
    pub pull_sigma_rad_per_m: f64,
    /// Alpha of the way back as measured \[rad\], clockwise positive.
    pub back_alpha_rad: f64,
    /// Which of the two is beyond noise.
    pub verdict: CurvatureCause,
}

impl OutAndBack {
    /// Separates radius from pull.
    pub fn new(
        forward: Leg,
        backward: Leg,
        shared: Shared,
        geometry: &Geometry,
    ) -> Result<Self, OutAndBackError> {
        let legs = [forward, backward];
        if !legs.iter().all(Leg::is_sound) || !shared.alpha_covariance_rad2.is_finite() {
            return Err(OutAndBackError::BadNumber);
        }
        let radius_m = geometry.wheel_radius_m;
        let same_way = forward.turns.left * backward.turns.left >= 0.0
            || legs.iter().any(|leg| leg.turns.left * leg.turns.right <= 0.0);
        if same_way {
            return Err(OutAndBackError::SameDirection);
        }

        // (1) as  q W_T - |s| p = c  with  q = R_L phi_R / b,  c = R_L phi_L / b - alpha.
        let q = legs.map(|leg| radius_m * leg.turns.right / geometry.track_width_m);
        let c = legs.map(|leg| radius_m * leg.turns.left / geometry.track_width_m - leg.alpha_rad);
        let s_m = legs.map(|leg| {
            (radius_m * leg.turns.left - geometry.track_width_m * leg.alpha_rad / 2.0).abs()
        });
        let determinant = q[1] * s_m[0] - q[0] * s_m[1];
        let wheel_weight = (s_m[0] * c[1] - s_m[1] * c[0]) / determinant;
        let pull_rad_per_m = (q[0] * c[1] - q[1] * c[0]) / determinant;

        // Both results are weighted sums of the two alphas. The rounding of the encoders counts as an error of
        // alpha; the way back begins at the count at which the way out ended.
        let rounding_rad2 =
            (radius_m / geometry.track_width_m * geometry.rad_per_count()).powi(2) / 6.0;
        let variance = legs.map(|leg| leg.alpha_sigma_rad.powi(2) + 2.0 * rounding_rad2);
        let covariance = shared.alpha_covariance_rad2 - rounding_rad2;
        let sigma_of = |out: f64, back: f64| -> f64 {
            let square =
                out * out * variance[0] + back * back * variance[1] + 2.0 * out * back * covariance;
            square.max(0.0).sqrt() / determinant.abs()
        };
        let noise = sigma_of(s_m[1], -s_m[0]);
        let pull_noise_rad_per_m = sigma_of(q[1], -q[0]);
        let turns = forward.turns;
        let radius_alpha_rad =
            radius_m * (turns.left - wheel_weight * turns.right) / geometry.track_width_m;
        let radius_alpha_sigma_rad = (q[0] * noise).abs();

        // (2): errors of the nominal robot change either part in proportion, so they cannot lift it above noise.
        let by_track = radius_alpha_rad / (radius_m * turns.right);
        let radius_share =
            shared.measured_by.radius_power() * geometry.wheel_radius_sigma_m / radius_m;
        let wheel_weight_sigma = noise
            .hypot(by_track * geometry.track_width_sigma_m)
            .hypot(by_track * geometry.track_width_m * radius_share);
        let pull_sigma_rad_per_m = pull_noise_rad_per_m.hypot(pull_rad_per_m * radius_share);

        let radius = radius_alpha_rad.abs() > SIGMAS_95 * radius_alpha_sigma_rad;
        let pull = pull_rad_per_m.abs() > SIGMAS_95 * pull_noise_rad_per_m;
        Ok(Self {
            wheel_weight,
            wheel_weight_sigma,
            radius_alpha_rad,
            radius_alpha_sigma_rad,
            pull_rad_per_m,
            pull_sigma_rad_per_m,
            back_alpha_rad: backward.alpha_rad,
            verdict: CurvatureCause::of(radius, pull),
        })
    }
}

impl Leg {
    fn is_sound(&self) -> bool {
        let WheelPair { left: phi_left_rad, right: phi_right_rad } = self.turns;
        [self.alpha_rad, phi_left_rad, phi_right_rad].into_iter().all(f64::is_finite)
            && self.alpha_sigma_rad >= 0.0
            && self.alpha_sigma_rad.is_finite()
    }
}

/// Why radius and pull cannot be separated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OutAndBackError {
    /// Both runs went the same way.
    SameDirection,
    /// A number is not finite, or a sigma negative.
    BadNumber,
    /// One run was read by an offset, the other one by an angle.
    Mixed,
    /// The reading after one of the runs is impossible for such a run.
    Reading(WheelWeightError),
}

impl fmt::Display for OutAndBackError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

impl core::error::Error for OutAndBackError {}
