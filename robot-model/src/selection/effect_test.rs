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

use nalgebra::DVector;

use crate::effect::definition::{ActsOn, Effect, Parameter, Role};
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::normal_equations::{Columns, EquationsWithout, Sums};
use crate::numeric::distributions::{chi_squared, fisher};
use crate::numeric::parallel;
use crate::recording::run_kind::RunKind;
use crate::selection::dispersion::{Spread, known_from, spread};

pub(crate) use crate::selection::dispersion::{run_scatter_in_the_mean, scatter};

/// A kind of run may be predicted worse by this much in -2 log likelihood, by chance: two sigma.
const KIND_LOSS_MAX: f64 = 4.0;
/// A kind contradicts an effect if its gain lies this many sigmas below what the effect predicts.
const KIND_CONTRADICTS_SIGMAS: f64 = 3.5;
/// Runs of other kinds excite an effect if they alone determine it to within this share of its value.
const EXCITED_SHARE: f64 = 0.5;

/// An effect does not act on a kind that holds no more than this share of the information about it.
const ACTS_SHARE: f64 = 1e-3;

/// Fewer numbers than this do not tell the noise well: the ends of twenty runs are sixty.
const FEW_NUMBERS: f64 = 500.0;

/// Which columns are tested, given which.
pub(crate) struct Hypothesis<'q> {
    pub model: &'q [usize],
    pub asked: &'q [usize],
    pub effect: &'q dyn Effect,
    /// By how much runs disagree about everything else, [`scatter`].
    pub scatter: f64,
}

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
        self.cross_validated_gain > 0.0 && !self.implausible && self.own_share > OWN_SHARE_MIN
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

/// Gain of an effect, fitted to some folds, on others.
#[derive(Clone, Copy, Debug, Default)]
struct Gain {
    /// chi^2 without it less chi^2 with it.
    gain: f64,
    /// That gain if the effect were exactly as fitted: v'A v, with v the change of the fit by the effect.
    promised: f64,
    /// Its variance by the fit's uncertainty: v'A C A v, with C the fit's covariance.
    unknown: f64,
}

impl Gain {
    fn add(self, other: Self) -> Self {
        Self {
            gain: self.gain + other.gain,
            promised: self.promised + other.promised,
            unknown: self.unknown + other.unknown,
        }
    }

    /// By how many sigma the gain differs from the predicted one: if the effect is there, the gain is
    /// promised +- 2 sqrt(promised + unknown).
    fn kept_promise_sigmas(&self) -> f64 {
        (self.gain - self.promised) / (2.0 * (self.promised + self.unknown).sqrt())
    }
}

/// The gain on some folds of the effect fitted to others.
fn gain_on(
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

/// The kind of run that an effect fitted to the other kinds makes worst, if there is one.
///
/// Where the other kinds do not excite the effect, half of the kind's own folds join them. A kind on which it does not act
/// says nothing about it: there only the geometry fitted with it differs, and kinds disagree about that whenever anything
/// else is missing.
fn worse_kind(
    equations: &CampaignEquations,
    hypothesis: &Hypothesis<'_>,
    values: &[f64],
    dispersion: f64,
) -> Option<(RunKind, f64)> {
    let mut kinds: Vec<RunKind> = equations.folds.iter().map(|fold| fold.kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let both: Vec<usize> = hypothesis.model.iter().chain(hypothesis.asked).copied().collect();
    let first = hypothesis.model.len();
    let on_all: f64 =
        hypothesis.asked.iter().map(|column| equations.total.gram[(*column, *column)]).sum();
    let mut worst = None;
    for kind in kinds {
        let left_out: Vec<usize> = equations
            .folds
            .iter()
            .enumerate()
            .filter(|(_, fold)| fold.kind == kind)
            .map(|(index, _)| index)
            .collect();
        let on_kind: f64 = left_out
            .iter()
            .flat_map(|fold| {
                let gram = &equations.folds[*fold].sums.gram;
                hypothesis.asked.iter().map(|column| gram[(*column, *column)])
            })
            .sum();
        if on_kind <= ACTS_SHARE * on_all {
            continue;
        }
        let score = |left_out: &[usize]| {
            let rest = Columns::of(&equations.without(left_out.iter().copied()), &both);
            let on = EquationsWithout::new(&equations.total, vec![&rest]);
            let covariance = equations.solve(&rest, &both).covariance;
            let excited = values.iter().enumerate().any(|(j, value)| {
                covariance[(first + j, first + j)].sqrt() < EXCITED_SHARE * value.abs()
            });
            let gain = gain_on(equations, hypothesis, &rest, &on);
            let share = Gain {
                gain: gain.gain / dispersion,
                promised: gain.promised / dispersion,
                unknown: gain.unknown / dispersion,
            };
            (excited, share)
        };
        let (excited, mut gain) = score(&left_out);
        if !excited {
            let half = |parity: usize| {
                let position = left_out.iter().enumerate();
                let part: Vec<usize> =
                    position.filter(|(i, _)| i % 2 == parity).map(|(_, index)| *index).collect();
                score(&part).1
            };
            gain = half(0).add(half(1));
        }
        let sigmas = gain.kept_promise_sigmas();
        let gain = gain.gain;
        let contradicts = gain < -KIND_LOSS_MAX && sigmas < -KIND_CONTRADICTS_SIGMAS;
        if contradicts && worst.is_none_or(|(_, least)| gain < least) {
            worst = Some((kind, gain));
        }
    }
    worst
}
