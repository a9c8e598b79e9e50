//! Tests one effect, given a model: is it there?
//!
//! With the normal equations A, b of each unit (run) about the model's best point, and e the effect's columns:
//!
//! ```text
//! gain       = chi^2(model) - chi^2(model + e)                                        (1)
//! cross-validated gain = sum over units of that gain on a unit, both fitted to all others  (2)
//! u_r        = b_e - A_em A_mm^-1 b_m of unit r: its score                            (3)
//! phi        = (n + 1)/n  sum u_r' C^-1 u_r / q after the effect, C = sum cov(u_r)    (4)
//! ```
//!
//! (4), the dispersion, is by how much more the units disagree about the effect than their noise explains; it is 1
//! if the noise is right and the effect is the same in all runs. It is taken as at least 1, and shrunk towards a
//! prior, as few units tell little about it: an effect that shows in one run is not tested against that run's noise
//! alone, but against how much runs disagree about everything else ([`scatter`]). The p-value is that of gain / phi
//! by Fisher's F; the degrees of freedom of phi are those of the runs plus those of the prior.
//!
//! The gains of an effect that shows in few runs differ widely from run to run, which says nothing against it. Of
//! the units that it touches, each has one vote, whether it gets better:
//!
//! ```text
//! touched: d_r^2 = values' cov(u_r) values > 1,    better: 2 values' u_r > d_r^2         (5)
//! ```
//!
//! with u_r about the model without the effect. If it is there, more than half of them get better.

use nalgebra::{DMatrix, DVector};

use crate::effect::definition::{Effect, Role};
use crate::estimation::normal_equations::{CampaignEquations, NormalEquations};
use crate::numeric::distributions::{chi_squared, fisher};
use crate::recording::run_kind::RunKind;

/// Weight of the prior, in units: runs disagree about this effect as they do about others.
const PRIOR_UNITS: f64 = 4.0;
/// Fewest degrees of freedom that tell how much runs disagree.
const FREEDOM_MIN: f64 = 3.0;
/// A kind of run may be predicted worse by this much in -2 log likelihood, by chance: two sigma.
const KIND_LOSS_MAX: f64 = 4.0;
/// A kind contradicts an effect if its gain lies this many sigmas below what the effect predicts.
const KIND_CONTRADICTS_SIGMAS: f64 = 3.5;
/// Runs of other kinds excite an effect if they alone determine it to within this share of its value.
const EXCITED_SHARE: f64 = 0.5;

/// Which columns are tested, given which.
pub(crate) struct Hypothesis<'q> {
    pub model: &'q [usize],
    pub asked: &'q [usize],
    pub effect: &'q dyn Effect,
    /// By how much runs disagree about everything else, [`scatter`].
    pub scatter: f64,
}

/// The typical dispersion, equation (4), at least 1: the median over these pairs of a model's columns and the columns
/// tested.
pub(crate) fn scatter<'q>(
    equations: &CampaignEquations,
    asked: impl Iterator<Item = (&'q [usize], &'q [usize])>,
) -> f64 {
    let mut raws: Vec<f64> = asked
        .filter_map(|(model, asked)| {
            let both: Vec<usize> = model.iter().chain(asked).copied().collect();
            let delta = equations.solve(&equations.total, &both).delta;
            let spread = spread(equations, (model, asked), &delta);
            (spread.freedom >= FREEDOM_MIN).then_some(spread.raw)
        })
        .collect();
    raws.sort_by(f64::total_cmp);
    raws.get(raws.len() / 2).map_or(1.0, |median| median.max(1.0))
}

/// Median of a chi^2 of three degrees of freedom, divided by three.
const MEDIAN_PER_DEGREE: f64 = 0.79;

/// By how much more runs differ in parameters of their own than their noise explains, in the median; at least 1.
///
/// A test of single runs has to stand out from this: runs that differ by accident do so whether they are loaded or
/// not.
pub(crate) fn run_scatter(equations: &CampaignEquations, model: &[usize], own: &[usize]) -> f64 {
    let mut shares = run_shares(equations, model, own);
    shares.sort_by(f64::total_cmp);
    shares.get(shares.len() / 2).map_or(1.0, |median| (median / MEDIAN_PER_DEGREE).max(1.0))
}

/// The same in the mean: a trend over runs has to stand out from the few runs that differ much, too.
pub(crate) fn run_scatter_in_the_mean(
    equations: &CampaignEquations,
    model: &[usize],
    own: &[usize],
) -> f64 {
    let shares = run_shares(equations, model, own);
    (shares.iter().sum::<f64>() / shares.len().max(1) as f64).max(1.0)
}

/// Gain of each run by these columns fitted to that run alone, per degree of freedom.
fn run_shares(equations: &CampaignEquations, model: &[usize], own: &[usize]) -> Vec<f64> {
    let best = equations.solve(&equations.total, model).delta;
    equations
        .units
        .iter()
        .filter_map(|unit| {
            let gram = &unit.sums.gram;
            let known = |i: usize| equations.priors[i].spread.powi(-2);
            let matrix = DMatrix::from_fn(own.len(), own.len(), |i, j| gram[(own[i], own[j])]);
            let right = DVector::from_fn(own.len(), |i, _| {
                let explained = model.iter().zip(&best);
                unit.sums.right[own[i]]
                    - explained.map(|(j, d)| gram[(own[i], *j)] * d).sum::<f64>()
            });
            let prior = DVector::from_fn(own.len(), |i, _| known(own[i]));
            let factor = (&matrix + DMatrix::from_diagonal(&prior)).cholesky()?;
            let freedom = factor.solve(&matrix).trace();
            (freedom > 0.5).then(|| right.dot(&factor.solve(&right)) / freedom)
        })
        .collect()
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
    /// Equation (4), at least 1.
    pub dispersion: f64,
    /// Probability of at least this gain by chance.
    pub p_value: f64,
    /// The same, if the dispersion were known exactly.
    pub p_value_of_many: f64,
    /// One unit alone holds nearly all information about it. The cross-validated gain is then the one to be expected
    /// on as much data again.
    pub one_run_alone: bool,
    /// Fitted amplitudes.
    pub values: Vec<f64>,
    /// The values are outside what any robot can have.
    pub implausible: bool,
    /// The greatest share of a column's information that is its own, not the model's as well.
    pub own_share: f64,
    /// Equation (5): how many units it touches, and how many of those it improves.
    pub touched: usize,
    pub better: usize,
    /// A kind of run that it predicts worse when fitted to the others, and by how much.
    pub worse_kind: Option<(RunKind, f64)>,
}

impl EffectTest {
    /// Cross-validated runs get better, and the value is physical.
    pub fn is_sound(&self) -> bool {
        self.cross_validated_gain > 0.0 && !self.implausible && self.own_share > OWN_SHARE_MIN
    }

    /// Of the units that it touches, not more get worse than better.
    pub fn most_agree(&self) -> bool {
        2 * self.better >= self.touched
    }

    /// It is sound, and no kind of run gets worse.
    pub fn passes_cross_validation(&self) -> bool {
        self.is_sound() && self.most_agree() && self.worse_kind.is_none()
    }
}

/// Gain of an effect, fitted to some units, on others.
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

/// The gain on some units of the effect fitted to others.
fn gain_on(
    equations: &CampaignEquations,
    hypothesis: &Hypothesis<'_>,
    fitted_to: &NormalEquations,
    on: &NormalEquations,
) -> Gain {
    let both: Vec<usize> = hypothesis.model.iter().chain(hypothesis.asked).copied().collect();
    let without = equations.solve(fitted_to, hypothesis.model).delta;
    let solution = equations.solve(fitted_to, &both);
    let gain = on.chi_squared(hypothesis.model, &without) - on.chi_squared(&both, &solution.delta);
    let mut difference = solution.delta;
    for (i, value) in without.iter().enumerate() {
        difference[i] -= value;
    }
    let pull = DVector::from_fn(both.len(), |i, _| {
        both.iter().zip(&difference).map(|(j, d)| on.gram[(both[i], *j)] * d).sum()
    });
    Gain {
        gain,
        promised: difference.dot(&pull),
        unknown: (pull.transpose() * &solution.covariance * &pull)[0],
    }
}

/// Tests the hypothesis.
pub(crate) fn test_effect(
    equations: &CampaignEquations,
    hypothesis: &Hypothesis<'_>,
) -> EffectTest {
    let both: Vec<usize> = hypothesis.model.iter().chain(hypothesis.asked).copied().collect();
    let solution = equations.solve(&equations.total, &both);
    let first = hypothesis.model.len();
    let gain = gain_on(equations, hypothesis, &equations.total, &equations.total).gain;
    let cross_validated_gain = equations
        .units
        .iter()
        .enumerate()
        .map(|(index, unit)| {
            let others = equations.without(|other, _| other == index);
            gain_on(equations, hypothesis, &others, &unit.sums).gain
        })
        .sum();
    let spread = spread(equations, (hypothesis.model, hypothesis.asked), &solution.delta);
    let dispersion = spread.dispersion(hypothesis.scatter);
    let Spread { own_share, touched, better, one_run_alone, freedom, .. } = spread;
    // Without the one unit that shows it, it cannot be fitted: in place of the cross-validated gain stands the one
    // to be expected on as much data again, less what chance gives.
    let cross_validated_gain = if one_run_alone {
        gain - 2.0 * hypothesis.asked.len() as f64
    } else {
        cross_validated_gain
    };
    let parameters = hypothesis.effect.facts().parameters.iter();
    let limits: Vec<(f64, f64)> = parameters
        .filter(|parameter| parameter.role == Role::Amplitude)
        .map(|parameter| (parameter.low, parameter.high))
        .collect();
    let values: Vec<f64> = (0..hypothesis.asked.len()).map(|j| solution.delta[first + j]).collect();
    let sigmas: Vec<f64> = (0..hypothesis.asked.len())
        .map(|j| (dispersion * solution.covariance[(first + j, first + j)]).sqrt())
        .collect();
    let implausible = values
        .iter()
        .zip(&sigmas)
        .zip(&limits)
        // By more than chance explains.
        .any(|((value, sigma), (low, high))| {
            *value < low - 2.0 * sigma || *value > high + 2.0 * sigma
        });
    let p_value_of_many = chi_squared(hypothesis.asked.len(), gain / dispersion);
    EffectTest {
        gain,
        cross_validated_gain,
        dispersion,
        p_value: known_from(equations, freedom).map_or(p_value_of_many, |degrees| {
            fisher(hypothesis.asked.len(), degrees, gain / dispersion)
        }),
        p_value_of_many,
        own_share,
        touched,
        better,
        one_run_alone,
        worse_kind: worse_kind(equations, hypothesis, &values, dispersion),
        values,
        implausible,
    }
}

/// The degrees of freedom of phi: those of the effect's own runs, those of the prior, and those of all runs of the
/// campaign, as the prior is how much these disagree about everything else.
///
/// `None` for a single run: it tells nothing about how runs differ, and whoever shows the result has to say so.
fn known_from(equations: &CampaignEquations, freedom: f64) -> Option<f64> {
    let mut runs: Vec<usize> = equations.units.iter().map(|unit| unit.run).collect();
    runs.dedup();
    (runs.len() > 1).then_some(PRIOR_UNITS + freedom + (runs.len() as f64 - 1.0))
}

/// How much units disagree about an effect.
struct Spread {
    /// Equation (4), and its degrees of freedom.
    raw: f64,
    freedom: f64,
    /// The share of the effect's information that is its own.
    own_share: f64,
    /// Equation (5).
    touched: usize,
    better: usize,
    /// One unit alone holds nearly all information about it.
    one_run_alone: bool,
}

impl Spread {
    /// Equation (4), shrunk towards the prior, at least 1.
    fn dispersion(&self, scatter: f64) -> f64 {
        let prior = PRIOR_UNITS * scatter.max(1.0);
        ((prior + self.freedom * self.raw) / (PRIOR_UNITS + self.freedom)).max(1.0)
    }
}

/// With at least this share of the information about an effect, a unit counts as the only one that shows it.
const SINGLE_UNIT_SHARE: f64 = 0.8;

/// Equations (4) and (5), with `delta` the model's values and the effect's.
fn spread(
    equations: &CampaignEquations,
    (m, e): (&[usize], &[usize]),
    delta: &DVector<f64>,
) -> Spread {
    let both: Vec<usize> = m.iter().chain(e).copied().collect();
    let pick = |sums: &NormalEquations, rows: &[usize], columns: &[usize]| {
        DMatrix::from_fn(rows.len(), columns.len(), |i, j| sums.gram[(rows[i], columns[j])])
    };
    let mut amm = pick(&equations.total, m, m);
    for (i, column) in m.iter().enumerate() {
        amm[(i, i)] += equations.priors[*column].spread.powi(-2);
    }
    let aem = pick(&equations.total, e, m);
    let projection = match amm.cholesky() {
        Some(factor) => factor.solve(&aem.transpose()).transpose(),
        None => DMatrix::zeros(e.len(), m.len()),
    };
    let mut scores: Vec<(DVector<f64>, DMatrix<f64>)> = Vec::new();
    let mut run = None;
    let mut total = DMatrix::zeros(e.len(), e.len());
    for unit in &equations.units {
        let left = DVector::from_iterator(both.len(), both.iter().map(|i| unit.sums.right[*i]))
            - pick(&unit.sums, &both, &both) * delta;
        let (of_model, of_effect) = (left.rows(0, m.len()), left.rows(m.len(), e.len()));
        let score = of_effect - &projection * of_model;
        let cross = pick(&unit.sums, e, m) * projection.transpose();
        let covariance = pick(&unit.sums, e, e) - &cross - cross.transpose()
            + &projection * pick(&unit.sums, m, m) * projection.transpose();
        total += &covariance;
        match scores.last_mut() {
            // Blocks of one run share its accidents: together they have one vote.
            Some((sum, known)) if run == Some(unit.run) => {
                *sum += score;
                *known += covariance;
            }
            _ => scores.push((score, covariance)),
        }
        run = Some(unit.run);
    }
    let q = e.len() as f64;
    let values = delta.rows(m.len(), e.len()).into_owned();
    let (mut touched, mut better) = (0, 0);
    let (mut most, mut all) = (0.0_f64, 0.0);
    for (score, covariance) in &scores {
        let promised = (values.transpose() * covariance * &values)[0];
        // The score is taken with the effect in the model; without the effect it is larger by this.
        let gain = 2.0 * values.dot(score) + promised;
        most = most.max(promised);
        all += promised;
        touched += usize::from(promised > 1.0);
        better += usize::from(promised > 1.0 && gain > 0.0);
    }
    let one_run_alone = most > SINGLE_UNIT_SHARE * all;
    let own_share = (0..e.len())
        .map(|j| total[(j, j)] / equations.total.gram[(e[j], e[j])].max(f64::MIN_POSITIVE))
        .fold(0.0, f64::max);
    let ridge = total.diagonal().max() * 1e-9 + f64::MIN_POSITIVE;
    let Some(factor) = (total + DMatrix::identity(e.len(), e.len()) * ridge).cholesky() else {
        return Spread { raw: 1.0, freedom: 0.0, own_share, touched, better, one_run_alone };
    };
    let (mut sum, mut shares, mut squared_shares) = (0.0, 0.0, 0.0);
    for (score, covariance) in &scores {
        sum += score.dot(&factor.solve(score));
        let share = factor.solve(covariance).trace() / q;
        shares += share;
        squared_shares += share * share;
    }
    if squared_shares <= 0.0 {
        return Spread { raw: 1.0, freedom: 0.0, own_share, touched, better, one_run_alone };
    }
    // Effective number of units that hold information about it; the fit uses up one of them.
    let units = shares * shares / squared_shares;
    let freedom = (units - 1.0).max(0.0);
    let raw = if freedom > 0.0 { sum / q * units / freedom } else { 1.0 };
    Spread { raw, freedom, own_share, touched, better, one_run_alone }
}

/// The kind of run that an effect fitted to the other kinds makes worst, if there is one.
///
/// Where the other kinds do not excite the effect, half of the kind's own units join them.
fn worse_kind(
    equations: &CampaignEquations,
    hypothesis: &Hypothesis<'_>,
    values: &[f64],
    dispersion: f64,
) -> Option<(RunKind, f64)> {
    let mut kinds: Vec<RunKind> = equations.units.iter().map(|unit| unit.kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let both: Vec<usize> = hypothesis.model.iter().chain(hypothesis.asked).copied().collect();
    let first = hypothesis.model.len();
    let mut worst = None;
    for kind in kinds {
        let left_out: Vec<usize> = equations
            .units
            .iter()
            .enumerate()
            .filter(|(_, unit)| unit.kind == kind)
            .map(|(index, _)| index)
            .collect();
        let score = |left_out: &dyn Fn(usize) -> bool| {
            let rest = equations.without(|index, _| left_out(index));
            let mut on = equations.total.clone();
            on.add(&rest, -1.0);
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
        let (excited, mut gain) = score(&|index| left_out.contains(&index));
        if !excited {
            let half = |parity: usize| {
                let position = left_out.iter().enumerate();
                let part: Vec<usize> =
                    position.filter(|(i, _)| i % 2 == parity).map(|(_, index)| *index).collect();
                score(&|index| part.contains(&index)).1
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
