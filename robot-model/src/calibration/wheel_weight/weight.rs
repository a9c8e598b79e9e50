//! W_T with its uncertainty, the contributions to that, and what would reduce it.

use super::uncertainty::{Contribution, Source};
use crate::kinematics::geometry::Geometry;
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::distributions::SIGMAS_95;

/// An angle and its standard uncertainty.
pub(crate) struct Angle {
    pub(crate) rad: f64,
    pub(crate) sigma_rad: f64,
}

/// The right wheel's radius relative to the left one's, W_T = R_R / R_L (3-5), and how sure it is.
#[derive(Clone, Debug, PartialEq)]
pub struct WheelWeight {
    /// W_T.
    pub value: f64,
    /// Its standard uncertainty.
    pub sigma: f64,
    /// Lower end of the 95 % interval.
    pub low95: f64,
    /// Upper end of the 95 % interval.
    pub high95: f64,
    /// Deviation angle, **clockwise positive** \[rad\].
    pub alpha_rad: f64,
    /// Its standard uncertainty \[rad\].
    pub alpha_sigma_rad: f64,
    /// Contributions to the uncertainty, largest first; their squares add up to `sigma` squared.
    pub contributions: Vec<Contribution>,
    /// How far the wheels turned in the run that it comes from.
    pub turns: WheelPair<f64>,
    /// What would reduce the uncertainty most.
    pub advice: Advice,
}

impl WheelWeight {
    /// Puts the parts together, the largest contribution first, still without advice.
    pub(crate) fn from_parts(
        value: f64,
        alpha: Angle,
        turns: WheelPair<f64>,
        contributions: Vec<Contribution>,
    ) -> Self {
        let mut contributions: Vec<_> = contributions
            .into_iter()
            .map(|part| Contribution { sigma: part.sigma.abs(), ..part })
            .filter(|part| part.sigma > 0.0)
            .collect();
        contributions.sort_by(|a, b| b.sigma.total_cmp(&a.sigma));
        let sigma = contributions.iter().fold(0.0, |sum, part| part.sigma.hypot(sum));
        Self {
            value,
            sigma,
            low95: value - SIGMAS_95 * sigma,
            high95: value + SIGMAS_95 * sigma,
            alpha_rad: alpha.rad,
            alpha_sigma_rad: alpha.sigma_rad,
            contributions,
            turns,
            advice: Advice::NONE,
        }
    }

    /// The largest contribution and its share of the variance; encoders always contribute.
    pub(crate) fn dominating(&self) -> (Source, f64) {
        match self.contributions.first() {
            Some(part) => (part.source, (part.sigma / self.sigma).powi(2)),
            None => (Source::Reading, 0.0),
        }
    }

    /// Sigma without the sources of which `left_out` is true.
    pub(crate) fn sigma_without(&self, left_out: impl Fn(Source) -> bool) -> f64 {
        let rest = self.contributions.iter().filter(|part| !left_out(part.source));
        rest.fold(0.0, |sum, part| part.sigma.hypot(sum))
    }

    /// The right wheel's radius, R_R = W_T R_L \[m\].
    pub fn right_radius_m(&self, geometry: &Geometry) -> f64 {
        self.value * geometry.wheel_radius_m
    }

    /// The dominating contribution and the measurement that would reduce it.
    pub fn what_would_reduce_it_most(&self) -> &Advice {
        &self.advice
    }
}

/// The measurement that would help most.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// What dominates the uncertainty.
    pub dominating: Source,
    /// Its share of the variance, 0 to 1.
    pub share: f64,
    /// What to do.
    pub action: Action,
    /// The sigma of W_T that it would give.
    pub sigma_then: f64,
}

impl Advice {
    /// No advice yet.
    pub(crate) const NONE: Self = Self {
        dominating: Source::Reading,
        share: 0.0,
        action: Action::DriveTwiceAsFar,
        sigma_then: 0.0,
    };
}

/// A measurement that would make W_T surer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Measure the lateral offset at the end instead of the tangent.
    OffsetInsteadOfTangent,
    /// Measure the lateral offset at the end instead of the heading.
    OffsetInsteadOfHeading {
        /// Standard uncertainty of the offset \[m\].
        sigma_m: f64,
    },
    /// Use a longer base for the tangent.
    LongerBase {
        /// Length of the base \[m\].
        dx_m: f64,
    },
    /// Drive twice as far.
    DriveTwiceAsFar,
    /// Read the lateral offset half way as well as at the end, so that the alignment cancels.
    OffsetHalfWayToo,
    /// Calibrate once more, starting from this W_T.
    CalibrateOnceMore,
    /// Drive four such runs and take their mean.
    FourRuns,
}
