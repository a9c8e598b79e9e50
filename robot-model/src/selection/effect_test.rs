//! Tests one effect, given a model: is it there?
//!
//! With the normal equations A, b of each fold (run) about the model's best point, and e the effect's columns:
//!
//! ```text
//! gain       = chi^2(model) - chi^2(model + e)                                        (1)
//! cross-validated gain = sum over folds of that gain on a fold, both fitted to all others  (2)
//! ```
//!
//! The significance of the gain allows for how much the folds disagree, by equation (4) of
//! [`crate::selection::dispersion`]: the p-value is that of gain / phi by Fisher's F, with the degrees of freedom of the
//! runs plus those of the prior. The search over effects is in [`crate::selection::select`].

use crate::effect::definition::{ActsOn, Parameter, Role};
use crate::estimation::campaign_equations::CampaignEquations;
use crate::numeric::distributions::{chi_squared, fisher};
use crate::numeric::parallel;
use crate::recording::run_kind::RunKind;
use crate::selection::by_kind::worse_kind;
use crate::selection::dispersion::{Spread, known_from, spread};
use crate::selection::gain::{BLUR_MAX, Hypothesis, blurs_geometry, gain_on};

pub(crate) use crate::selection::dispersion::{run_scatter_in_the_mean, scatter};

/// Fewer numbers than this do not tell the noise well: the ends of twenty runs are sixty.
const FEW_NUMBERS: f64 = 500.0;

/// Below this share, an effect rests on the small difference of two large ones, which anything that
/// is not in the model may imitate.
pub(crate) const OWN_SHARE_MIN: f64 = 0.02;

/// The result of the test of an effect.
#[derive(Clone, Debug, Default)]
pub(crate) struct EffectTest {
    /// Equation (1).
    pub gain: f64,
    /// Equation (2).
    pub cross_validated_gain: f64,
    /// Equation (4) of [`crate::selection::dispersion`], at least 1.
    pub dispersion: f64,
    /// Probability of at least this gain by chance.
    pub p_value: f64,
    /// The same, if the dispersion were known exactly.
    pub p_value_of_many: f64,
    /// How many parameters it has, and the degrees of freedom of the dispersion.
    pub own: usize,
    pub known_from: Option<f64>,
    /// Few numbers were measured in all runs.
    pub few_numbers: bool,
    /// It has a shape, which is fitted to all folds: its gain (2) is not altogether cross-validated.
    pub has_shape: bool,
    /// It acts on a sensor and moves no track, so no track says anything against it.
    pub moves_no_track: bool,
    /// One fold alone holds nearly all information about it. The cross-validated gain is then the one to be expected
    /// on as much data again.
    pub one_run_alone: bool,
    /// Fitted amplitudes.
    pub values: Vec<f64>,
    /// The values are outside what any robot can have.
    pub implausible: bool,
    /// The greatest share of a column's information that is its own, not the model's as well.
    pub own_share: f64,
    /// By how much more uncertain radii and track width are beside it: the greatest ratio of standard errors.
    pub blurs_geometry: f64,
    /// Equation (5) of [`crate::selection::dispersion`]: how many folds it touches, and how many of those it improves.
    pub touched: usize,
    pub better: usize,
    /// The runs that show it.
    pub shown_by: Vec<usize>,
    /// A kind of run that it predicts worse when fitted to the others, and by how much.
    pub worse_kind: Option<(RunKind, f64)>,
}

impl EffectTest {
    /// Cross-validated runs get better, and the value is physical.
    pub fn is_sound(&self) -> bool {
        self.cross_validated_gain > 0.0
            && !self.implausible
            && self.own_share > OWN_SHARE_MIN
            && self.blurs_geometry < BLUR_MAX
    }

    /// The same test, with a gain of at most this in place of (1).
    pub fn with_gain_at_most(&self, most: f64) -> Self {
        let gain = self.gain.min(most);
        let p_value = probability(self.own, self.known_from, gain / self.dispersion);
        Self { gain, p_value: p_value.max(self.p_value), ..self.clone() }
    }

    /// Of the folds that it touches, not more get worse than better.
    pub fn most_agree(&self) -> bool {
        2 * self.better >= self.touched
    }

    /// Cross-validated runs get better. This is all that is asked of radii and track width: they may be far from what
    /// the robot's file says, and nothing else is fitted before them.
    pub fn predicts_better(&self) -> bool {
        self.cross_validated_gain > 0.0
    }

    /// It is sound, and no kind of run gets worse.
    pub fn passes_cross_validation(&self) -> bool {
        self.is_sound() && self.most_agree() && self.worse_kind.is_none()
    }
}

/// Tests the hypothesis, with amplitudes that are never negative at zero where they would be.
pub(crate) fn test_effect(
    equations: &CampaignEquations,
    hypothesis: &Hypothesis<'_>,
) -> EffectTest {
    let parameters = hypothesis.effect.facts().parameters;
    let amplitudes: Vec<&Parameter> =
        parameters.iter().filter(|of| of.role == Role::Amplitude).collect();
    let free = test_amplitudes(equations, hypothesis, &amplitudes);
    let values = amplitudes.iter().zip(&free.values);
    let at_zero: Vec<bool> =
        values.map(|(of, value)| of.is_never_negative() && *value < 0.0).collect();
    if at_zero.iter().all(|at_zero| *at_zero) || !at_zero.contains(&true) {
        return free;
    }
    let others = hypothesis.asked.iter().zip(amplitudes).zip(&at_zero);
    let others = others.filter(|(_, at_zero)| !**at_zero).map(|((column, of), _)| (*column, of));
    let (asked, amplitudes): (Vec<usize>, Vec<&Parameter>) = others.unzip();
    let pinned = Hypothesis { asked: &asked, ..*hypothesis };
    let mut test = test_amplitudes(equations, &pinned, &amplitudes);
    let mut values = test.values.into_iter();
    test.values = at_zero
        .iter()
        .map(|at_zero| if *at_zero { 0.0 } else { values.next().unwrap_or(0.0) })
        .collect();
    test
}

/// Tests the hypothesis, for the amplitudes in the columns that it asks for, whatever their signs.
fn test_amplitudes(
    equations: &CampaignEquations,
    hypothesis: &Hypothesis<'_>,
    amplitudes: &[&Parameter],
) -> EffectTest {
    let both: Vec<usize> = hypothesis.model.iter().chain(hypothesis.asked).copied().collect();
    let solution = equations.solve(&equations.total, &both);
    let first = hypothesis.model.len();
    let gain = gain_on(equations, hypothesis, &equations.total, &equations.total).gain;
    let folds: Vec<usize> = (0..equations.folds.len()).collect();
    let on_each = parallel::map(&folds, |index| {
        let others = equations.without([*index]);
        gain_on(equations, hypothesis, &others, &equations.folds[*index].sums).gain
    });
    let cross_validated_gain = on_each.into_iter().sum();
    let spread = spread(equations, (hypothesis.model, hypothesis.asked), &solution.delta);
    let dispersion = spread.dispersion(hypothesis.scatter);
    let Spread { own_share, touched, better, shown_by, one_run_alone, freedom, .. } = spread;
    // Without the one fold that shows it, it cannot be fitted: in place of the cross-validated gain stands the one
    // to be expected on as much data again, less what chance gives.
    let cross_validated_gain = if one_run_alone {
        gain - 2.0 * hypothesis.asked.len() as f64
    } else {
        cross_validated_gain
    };
    let values: Vec<f64> = (0..hypothesis.asked.len()).map(|j| solution.delta[first + j]).collect();
    let sigmas: Vec<f64> = (0..hypothesis.asked.len())
        .map(|j| (dispersion * solution.covariance[(first + j, first + j)]).sqrt())
        .collect();
    let implausible = values.iter().zip(&sigmas).zip(amplitudes).any(|((value, sigma), of)| {
        // By more than chance explains; a play or a threshold that no robot has is no answer, however uncertain.
        let above = if of.is_never_negative() { 0.0 } else { 2.0 * sigma };
        *value < of.low - 2.0 * sigma || *value > of.high + above
    });
    // A shape is fitted as well, to whatever chance offers.
    let own = hypothesis.asked.len().max(hypothesis.effect.facts().parameters.len());
    let p_value_of_many = chi_squared(own, gain / dispersion);
    let known_from = known_from(equations, freedom);
    EffectTest {
        gain,
        cross_validated_gain,
        dispersion,
        p_value: probability(own, known_from, gain / dispersion),
        p_value_of_many,
        own,
        known_from,
        few_numbers: equations.total.rows < FEW_NUMBERS,
        has_shape: own > hypothesis.asked.len(),
        moves_no_track: hypothesis.effect.facts().acts_on == ActsOn::Gyro,
        own_share,
        blurs_geometry: blurs_geometry(
            equations,
            hypothesis,
            (&equations.total, &solution.covariance),
        ),
        touched,
        better,
        shown_by,
        one_run_alone,
        worse_kind: worse_kind(equations, hypothesis, &values, dispersion),
        values,
        implausible,
    }
}

/// Probability by chance of at least this gain by so many parameters, over a dispersion of so many degrees of freedom.
fn probability(own: usize, known_from: Option<f64>, gain: f64) -> f64 {
    known_from.map_or_else(|| chi_squared(own, gain), |degrees| fisher(own, degrees, gain))
}
