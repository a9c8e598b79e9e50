//! By how much more do runs disagree about an effect than their noise explains?
//!
//! With the normal equations A, b of each fold (run), m the columns of a model and e those of the effect:
//!
//! ```text
//! u_r = b_e - A_em A_mm^-1 b_m of fold r: its score                                  (3)
//! phi = (n + 1)/n  sum u_r' C^-1 u_r / q after the effect, C = sum cov(u_r)          (4)
//! ```
//!
//! phi, the dispersion, is 1 if the noise is right and the effect is the same in all runs. It is taken as at least 1,
//! and shrunk towards a prior, as few folds tell little about it: an effect that shows in one run is not tested against
//! that run's noise alone, but against how much runs disagree about everything else ([`scatter`]).
//!
//! The gains of an effect that shows in few runs differ widely from run to run, which says nothing against it. Of
//! the folds that it touches, each has one vote, whether it gets better:
//!
//! ```text
//! touched: d_r^2 = values' cov(u_r) values > 1,    better: 2 values' u_r > d_r^2     (5)
//! ```
//!
//! with u_r about the model without the effect. If the effect is there, more than half of them get better. Of a weak
//! effect no run may be touched: the runs that show it are those of at least a quarter of the largest d_r^2.
//! What follows for the effect is decided in [`crate::selection::effect_test`].

use nalgebra::{DMatrix, DVector};

use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::normal_equations::NormalEquations;
use crate::numeric::parallel;

/// Weight of the prior, in folds: runs disagree about this effect as they do about others.
const PRIOR_UNITS: f64 = 4.0;
/// Fewest degrees of freedom that tell how much runs disagree.
const FREEDOM_MIN: f64 = 3.0;

/// The typical dispersion, equation (4), at least 1: the median over these pairs of a model's columns and the columns
/// tested.
pub(crate) fn scatter<'q>(
    equations: &CampaignEquations,
    asked: impl Iterator<Item = (&'q [usize], &'q [usize])>,
) -> f64 {
    let asked: Vec<_> = asked.collect();
    let raws = parallel::map(&asked, |(model, asked)| {
        let both: Vec<usize> = model.iter().chain(*asked).copied().collect();
        let delta = equations.best(&equations.total, &both);
        let spread = spread(equations, (model, asked), &delta);
        (spread.freedom >= FREEDOM_MIN).then_some(spread.raw)
    });
    let mut raws: Vec<f64> = raws.into_iter().flatten().collect();
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
    if shares.is_empty() {
        return 1.0;
    }
    // Of two runs the mean: one that differs is no scatter yet.
    let (below, above) = ((shares.len() - 1) / 2, shares.len() / 2);
    let median = f64::midpoint(shares[below], shares[above]);
    (median / MEDIAN_PER_DEGREE).max(1.0)
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
    let best = equations.best(&equations.total, model);
    equations
        .folds
        .iter()
        .filter_map(|fold| {
            let gram = &fold.sums.gram;
            let known = |i: usize| equations.priors[i].spread.powi(-2);
            let matrix = DMatrix::from_fn(own.len(), own.len(), |i, j| gram[(own[i], own[j])]);
            let right = DVector::from_fn(own.len(), |i, _| {
                let explained = model.iter().zip(&best);
                fold.sums.right[own[i]]
                    - explained.map(|(j, d)| gram[(own[i], *j)] * d).sum::<f64>()
            });
            let prior = DVector::from_fn(own.len(), |i, _| known(own[i]));
            let factor = (&matrix + DMatrix::from_diagonal(&prior)).cholesky()?;
            let freedom = factor.solve(&matrix).trace();
            (freedom > 0.5).then(|| right.dot(&factor.solve(&right)) / freedom)
        })
        .collect()
}

/// The degrees of freedom of phi: those of the effect's own runs, those of the prior, and those of all runs of the
/// campaign, as the prior is how much these disagree about everything else.
///
/// `None` for a single run: it tells nothing about how runs differ, and whoever shows the result has to say so.
pub(crate) fn known_from(equations: &CampaignEquations, freedom: f64) -> Option<f64> {
    let mut runs: Vec<usize> = equations.folds.iter().map(|fold| fold.run).collect();
    runs.dedup();
    (runs.len() > 1).then_some(PRIOR_UNITS + freedom + (runs.len() as f64 - 1.0))
}

/// How much folds disagree about an effect.
pub(crate) struct Spread {
    /// Equation (4), and its degrees of freedom.
    pub raw: f64,
    pub freedom: f64,
    /// The share of the effect's information that is its own.
    pub own_share: f64,
    /// Equation (5).
    pub touched: usize,
    pub better: usize,
    /// The runs that show it: those that it touches, or of a weak effect those that it moves most.
    pub shown_by: Vec<usize>,
    /// One fold alone holds nearly all information about it.
    pub one_run_alone: bool,
}

impl Spread {
    /// Equation (4), shrunk towards the prior, at least 1.
    pub fn dispersion(&self, scatter: f64) -> f64 {
        let prior = PRIOR_UNITS * scatter.max(1.0);
        ((prior + self.freedom * self.raw) / (PRIOR_UNITS + self.freedom)).max(1.0)
    }
}

/// With at least this share of the information about an effect, a fold counts as the only one that shows it.
const SINGLE_UNIT_SHARE: f64 = 0.8;
/// The runs that show a weak effect have at least this share of the largest d_r^2 of (5).
const SHOWN_SHARE: f64 = 0.25;

/// Equations (4) and (5), with `delta` the model's values and the effect's.
pub(crate) fn spread(
    equations: &CampaignEquations,
    (m, e): (&[usize], &[usize]),
    delta: &DVector<f64>,
) -> Spread {
    let (scores, total) = scores(equations, (m, e), delta);
    let q = e.len() as f64;
    let values = delta.rows(m.len(), e.len()).into_owned();
    let (mut touched, mut better) = (0, 0);
    let (mut most, mut all) = (0.0_f64, 0.0);
    let mut each = Vec::new();
    for Score { of: score, covariance, .. } in &scores {
        let promised = (values.transpose() * covariance * &values)[0];
        // The score is taken with the effect in the model; without the effect it is larger by this.
        let gain = 2.0 * values.dot(score) + promised;
        most = most.max(promised);
        all += promised;
        each.push(promised);
        touched += usize::from(promised > 1.0);
        better += usize::from(promised > 1.0 && gain > 0.0);
    }
    let least = f64::min(1.0, SHOWN_SHARE * most);
    let shown_by = scores.iter().zip(&each).filter(|(_, promised)| **promised > least);
    let shown_by: Vec<usize> = shown_by.map(|(score, _)| score.run).collect();
    let one_run_alone = most > SINGLE_UNIT_SHARE * all;
    let own_share = (0..e.len())
        .map(|j| total[(j, j)] / equations.total.gram[(e[j], e[j])].max(f64::MIN_POSITIVE))
        .fold(0.0, f64::max);
    // Where the folds do not tell how much their scores scatter.
    let untold =
        Spread { raw: 1.0, freedom: 0.0, own_share, touched, better, shown_by, one_run_alone };
    let ridge = total.diagonal().max() * 1e-9 + f64::MIN_POSITIVE;
    let Some(factor) = (total + DMatrix::identity(e.len(), e.len()) * ridge).cholesky() else {
        return untold;
    };
    let (mut sum, mut shares, mut squared_shares) = (0.0, 0.0, 0.0);
    for Score { of: score, covariance, .. } in &scores {
        sum += score.dot(&factor.solve(score));
        let share = factor.solve(covariance).trace() / q;
        shares += share;
        squared_shares += share * share;
    }
    if squared_shares <= 0.0 {
        return untold;
    }
    // Effective number of folds that hold information about it; the fit uses up one of them.
    let folds = shares * shares / squared_shares;
    let freedom = (folds - 1.0).max(0.0);
    let raw = if freedom > 0.0 { sum / q * folds / freedom } else { 1.0 };
    Spread { raw, freedom, ..untold }
}

/// The score of an effect in one run, and its covariance.
struct Score {
    run: usize,
    of: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// The score of the effect and its covariance, for each run; and the sum of the covariances.
fn scores(
    equations: &CampaignEquations,
    (m, e): (&[usize], &[usize]),
    delta: &DVector<f64>,
) -> (Vec<Score>, DMatrix<f64>) {
    let both: Vec<usize> = m.iter().chain(e).copied().collect();
    let mut amm = block(&equations.total, m, m);
    for (i, column) in m.iter().enumerate() {
        amm[(i, i)] += equations.priors[*column].spread.powi(-2);
    }
    let aem = block(&equations.total, e, m);
    let projection = match amm.cholesky() {
        Some(factor) => factor.solve(&aem.transpose()).transpose(),
        None => DMatrix::zeros(e.len(), m.len()),
    };
    let mut scores: Vec<Score> = Vec::new();
    let mut total = DMatrix::zeros(e.len(), e.len());
    for fold in &equations.folds {
        let left = DVector::from_iterator(both.len(), both.iter().map(|i| fold.sums.right[*i]))
            - block(&fold.sums, &both, &both) * delta;
        let (of_model, of_effect) = (left.rows(0, m.len()), left.rows(m.len(), e.len()));
        let score = of_effect - &projection * of_model;
        let cross = block(&fold.sums, e, m) * projection.transpose();
        let covariance = block(&fold.sums, e, e) - &cross - cross.transpose()
            + &projection * block(&fold.sums, m, m) * projection.transpose();
        total += &covariance;
        match scores.last_mut() {
            // Blocks of one run share its accidents: together they have one vote.
            Some(before) if before.run == fold.run => {
                before.of += score;
                before.covariance += covariance;
            }
            _ => scores.push(Score { run: fold.run, of: score, covariance }),
        }
    }
    (scores, total)
}

/// These rows and columns of A.
fn block(sums: &NormalEquations, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), columns.len(), |i, j| sums.gram[(rows[i], columns[j])])
}
