//! The paper's calculation: from the deviation at the end of a run to the wheel weight W_T.
//!
//! Symbols: R_L radius of the left wheel, b track width, phi_L and phi_R the angles that the wheels
//! turned, dS_L = R_L phi_L and dS_R = W_T R_L phi_R their travels, s = (dS_L + dS_R) / 2 the length
//! of the path, alpha the deviation angle, **clockwise positive** (to the right, as in the paper).
//!
//! ```text
//! alpha = (dS_L - dS_R) / b                                  (3-3)
//! W_T   = (R_L phi_L - b alpha) / (R_L phi_R)                (3-6), for wheels that turn differently
//! alpha = atan(dy_A / dx)                                    (3-2), from the tangent at the end
//! y     = -s (1 - cos alpha) / alpha                         exact arc, from the lateral offset
//! ```
//!
//! The general (3-6) is the paper's for phi_L = phi_R = 2 pi g C_T / N. Driving backwards, phi and
//! s are negative and every equation stands as it is. Uncertainty is propagated to first order.

mod arc;
mod error;
mod experiment;
#[cfg(test)]
mod tests;
mod uncertainty;

use crate::advice::Advice;
use crate::geometry::{Geometry, Turns};

pub(crate) use arc::Arc;
pub use error::WheelWeightError;
pub use experiment::{Deviation, Experiment};
pub use uncertainty::{Contribution, Source};

/// Half the width of a 95 % interval, in sigmas of a normal distribution.
pub const SIGMAS_95: f64 = 1.959_964;

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
    /// What the uncertainty is made of, largest first; their squares add up to `sigma` squared.
    pub contributions: Vec<Contribution>,
    /// How far the wheels turned in the run that it comes from.
    pub turns: Turns,
    /// What would reduce the uncertainty most.
    pub advice: Advice,
}

impl WheelWeight {
    /// Puts the parts together, the largest contribution first; the advice is still to be given.
    pub(crate) fn from_parts(
        value: f64,
        alpha: Angle,
        turns: Turns,
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

    /// The largest contribution and its share of the variance; encoders always leave one.
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

    /// The dominating contribution and the measurement that would shrink it.
    pub fn what_would_reduce_it_most(&self) -> &Advice {
        &self.advice
    }
}
