//! What is asked about an effect given a model, and what it gains.

use nalgebra::{DMatrix, DVector};

use crate::effect::definition::{Effect, Group};
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::normal_equations::Sums;

/// Which columns are tested, given which.
pub(crate) struct Hypothesis<'q> {
    pub model: &'q [usize],
    pub asked: &'q [usize],
    pub effect: &'q dyn Effect,
    /// The columns of radii and track width, of those in the model.
    pub geometry: &'q [usize],
    /// By how much runs disagree about everything else, [`scatter`].
    pub scatter: f64,
}

/// Gain of an effect, fitted to some folds, on others.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Gain {
    /// chi^2 without it less chi^2 with it.
    pub gain: f64,
    /// That gain if the effect were exactly as fitted: v'A v, with v the change of the fit by the effect.
    pub promised: f64,
    /// Its variance by the fit's uncertainty: v'A C A v, with C the fit's covariance.
    pub unknown: f64,
}

impl Gain {
    pub fn add(self, other: Self) -> Self {
        Self {
            gain: self.gain + other.gain,
            promised: self.promised + other.promised,
            unknown: self.unknown + other.unknown,
        }
    }

    /// By how many sigma the gain differs from the predicted one: if the effect is there, the gain is
    /// promised +- 2 sqrt(promised + unknown).
    pub fn kept_promise_sigmas(&self) -> f64 {
        (self.gain - self.promised) / (2.0 * (self.promised + self.unknown).sqrt())
    }
}

/// The gain on some folds of the effect fitted to others.
pub(crate) fn gain_on(
    equations: &CampaignEquations,
    hypothesis: &Hypothesis<'_>,
    fitted_to: &impl Sums,
    on: &impl Sums,
) -> Gain {
    let both: Vec<usize> = hypothesis.model.iter().chain(hypothesis.asked).copied().collect();
    let without = equations.best(fitted_to, hypothesis.model);
    let solution = equations.solve(fitted_to, &both);
    let gain = on.chi_squared(hypothesis.model, &without) - on.chi_squared(&both, &solution.delta);
    let mut difference = solution.delta;
    for (i, value) in without.iter().enumerate() {
        difference[i] -= value;
    }
    let pull = DVector::from_fn(both.len(), |i, _| {
        both.iter().zip(&difference).map(|(j, d)| on.gram(both[i], *j) * d).sum()
    });
    Gain {
        gain,
        promised: difference.dot(&pull),
        unknown: (pull.transpose() * &solution.covariance * &pull)[0],
    }
}

/// Beside an effect, radii and track width may be this many times as uncertain. Where they are more so, these runs can hardly
/// tell it from them: both may be far off and nearly cancel here, and do not where the robot drives otherwise.
pub(crate) const BLUR_MAX: f64 = 5.0;

/// By how much more uncertain radii and track width are with the effect than without it, by the covariance of both: the
/// greatest ratio of standard errors. An effect of radii and track width itself blurs nothing.
pub(crate) fn blurs_geometry(
    equations: &CampaignEquations,
    hypothesis: &Hypothesis<'_>,
    (fitted_to, with): (&impl Sums, &DMatrix<f64>),
) -> f64 {
    if hypothesis.effect.facts().group == Group::Geometry {
        return 1.0;
    }
    let without = equations.solve(fitted_to, hypothesis.model).covariance;
    let columns = hypothesis.model.iter().enumerate();
    columns
        .filter(|(_, column)| hypothesis.geometry.contains(column))
        .map(|(i, _)| (with[(i, i)] / without[(i, i)]).sqrt())
        .fold(1.0, f64::max)
}
