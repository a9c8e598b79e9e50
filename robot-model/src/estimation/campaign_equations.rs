//! What do the runs of a campaign tell about any set of parameters? Normal equations, one set for each run.
//!
//! After whitening, every refit, cross-validation and test is arithmetic on sums of these over runs. The fold is a run
//! throughout: samples of one run share its accidents. Which columns to fit is the caller's question. What a run is
//! predicted by when it is left out is in [`super::left_out`].

use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::effect::composition::{PlacedTerm, Terms};
use crate::effect::definition::Role;
use crate::estimation::ekf::whiten;
use crate::estimation::gyro::whiten_gyro;
use crate::estimation::normal_equations::{EquationsWithout, NormalEquations, Sums};
use crate::estimation::row_adder::{KeptRows, RowAdder};
use crate::recording::campaign::{Prepared, PreparedRun};
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::run_kind::RunKind;

/// A single run, or one that alone shows a column, is cut into this many blocks, so that it can be cross-validated.
const BLOCKS: usize = 8;
/// Of the rows of all runs so many numbers are kept at most until it is known which runs are cut into blocks: with them no
/// run has to be filtered again.
const ROWS_KEPT: usize = 1 << 23;
/// With this share of the information about a column, a run is the only one that shows it.
const ALONE_SHARE: f64 = 0.9;

/// What is left out at a time: a run, or a block of it where there is only one run.
#[derive(Clone, Debug)]
pub(crate) struct Fold {
    pub run: usize,
    pub kind: RunKind,
    pub sums: NormalEquations,
    /// The sums of its blocks, where it is the only one of several runs that shows a column.
    pub blocks: Vec<NormalEquations>,
}

impl Fold {
    /// Whether no other fold shows this column.
    pub fn alone_shows(&self, total: &NormalEquations, column: usize) -> bool {
        let (own, all) = (self.sums.gram[(column, column)], total.gram[(column, column)]);
        own > ALONE_SHARE * all
    }
}

/// The prior of a parameter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prior {
    /// How far the point of linearisation is from the prior's middle.
    pub from_middle: f64,
    pub spread: f64,
}

/// The normal equations about one point of all parameters.
#[derive(Clone, Debug)]
pub(crate) struct CampaignEquations {
    pub folds: Vec<Fold>,
    pub total: NormalEquations,
    pub priors: Vec<Prior>,
}

/// Values and covariance of some columns.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    pub delta: DVector<f64>,
    pub covariance: DMatrix<f64>,
}

/// The prior of each column, in order.
fn priors(terms: &[PlacedTerm<'_>]) -> Vec<Prior> {
    let mut priors = Vec::new();
    for term in terms {
        for (parameter, value) in term.effect.facts().parameters.iter().zip(&term.values) {
            // A shape has no value that means "not there": its prior only keeps a step within reason.
            let from_middle = if parameter.role == Role::Amplitude { *value } else { 0.0 };
            priors.push(Prior { from_middle, spread: parameter.spread() });
        }
    }
    priors
}

impl CampaignEquations {
    /// The normal equations of a campaign for these terms, all of whose parameters are free.
    pub fn gather(prepared: &Prepared, terms: &[PlacedTerm<'_>], noise: &OdometryNoise) -> Self {
        let free = Terms::Free(terms);
        let columns = free.columns();
        let whiten_run = |run: &PreparedRun, observer: &mut KeptRows| {
            whiten(&run.motion, &run.recording.measured_poses, free, noise, observer);
            whiten_gyro(run, free, noise, observer);
        };
        let adder = |run: &PreparedRun, blocks: usize| {
            RowAdder::new(columns, run.motion.steps.len(), blocks)
        };
        let only_run = prepared.runs.len() == 1;
        let blocks = if only_run { BLOCKS } else { 1 };
        let numbers_max = if only_run { 0 } else { ROWS_KEPT / prepared.runs.len().max(1) };
        let gathered = crate::numeric::parallel::map(&prepared.runs, |run| {
            let mut rows = KeptRows::new(adder(run, blocks), numbers_max);
            whiten_run(run, &mut rows);
            rows.sums()
        });
        let mut folds: Vec<Fold> = Vec::new();
        let mut rows = Vec::new();
        let mut total = NormalEquations::zeros(columns);
        for (run, (blocks, kept)) in gathered.into_iter().enumerate() {
            for sums in blocks {
                total.add(&sums);
                if sums.rows > 0.0 {
                    let kind = prepared.runs[run].kind;
                    folds.push(Fold { run, kind, sums, blocks: Vec::new() });
                }
            }
            rows.push(kept);
        }
        if !only_run {
            let is_alone =
                |fold: &&mut Fold| (0..columns).any(|column| fold.alone_shows(&total, column));
            let mut alone: Vec<&mut Fold> = folds.iter_mut().filter(is_alone).collect();
            let blocks = crate::numeric::parallel::map(&alone, |fold| {
                let run = &prepared.runs[fold.run];
                match &rows[fold.run] {
                    Some(kept) => kept.added_to(adder(run, BLOCKS)),
                    None => {
                        let mut again = KeptRows::new(adder(run, BLOCKS), 0);
                        whiten_run(run, &mut again);
                        again.sums().0
                    }
                }
            });
            for (fold, blocks) in alone.iter_mut().zip(blocks) {
                fold.blocks = blocks;
            }
        }
        Self { folds, total, priors: priors(terms) }
    }

    /// Moves the point of linearisation in one column.
    pub fn shift(&mut self, column: usize, delta: f64) {
        self.total.shift(column, delta);
        for fold in &mut self.folds {
            fold.sums.shift(column, delta);
            fold.blocks.iter_mut().for_each(|block| block.shift(column, delta));
        }
        self.priors[column].from_middle += delta;
    }

    /// The best values of these columns by these sums, with the others fixed, and their covariance.
    pub fn solve(&self, sums: &impl Sums, columns: &[usize]) -> Solution {
        let n = columns.len();
        let spread = |i: usize| self.priors[columns[i]].spread;
        let (factor, right) = self.factorised(sums, columns);
        let inverse = factor.map_or_else(|| DMatrix::identity(n, n), |factor| factor.inverse());
        let delta = DVector::from_fn(n, |i, _| spread(i) * (inverse.row(i) * &right)[0]);
        let covariance = DMatrix::from_fn(n, n, |i, j| spread(i) * inverse[(i, j)] * spread(j));
        Solution { delta, covariance }
    }

    /// The values of [`solve`](Self::solve) alone: it needs no inverse.
    pub fn best(&self, sums: &impl Sums, columns: &[usize]) -> DVector<f64> {
        let (factor, mut delta) = self.factorised(sums, columns);
        if let Some(factor) = factor {
            factor.solve_mut(&mut delta);
        }
        for (delta, column) in delta.iter_mut().zip(columns) {
            *delta *= self.priors[*column].spread;
        }
        delta
    }

    /// The equations of these columns, priors included, in units of the priors' spreads: so all numbers are comparable
    /// and the prior is the identity. Left side factorised, and right side.
    fn factorised(
        &self,
        sums: &impl Sums,
        columns: &[usize],
    ) -> (Option<Cholesky<f64, Dyn>>, DVector<f64>) {
        let n = columns.len();
        let spread = |i: usize| self.priors[columns[i]].spread;
        let mut matrix = DMatrix::zeros(n, n);
        let mut right = DVector::zeros(n);
        for j in 0..n {
            let prior = self.priors[columns[j]];
            // The factorisation reads the lower triangle alone.
            for i in j..n {
                matrix[(i, j)] = spread(i) * sums.gram(columns[i], columns[j]) * spread(j);
            }
            matrix[(j, j)] += 1.0;
            right[j] = spread(j) * sums.right(columns[j]) - prior.from_middle / prior.spread;
        }
        (matrix.cholesky(), right)
    }

    /// By how much chi^2 and the priors' part fall with this step in these columns, if they are as at this point.
    pub fn expected_fall(&self, columns: &[usize], step: &DVector<f64>) -> f64 {
        let falls = columns.iter().zip(step.iter()).map(|(column, step)| {
            let prior = &self.priors[*column];
            step * (self.total.right[*column] - prior.from_middle / prior.spread.powi(2))
        });
        falls.sum()
    }

    /// The priors' part of chi^2 at this point.
    pub fn prior_cost(&self) -> f64 {
        self.priors.iter().map(|prior| (prior.from_middle / prior.spread).powi(2)).sum()
    }

    /// Expected gain in -2 log likelihood of these columns at these values, if they are the truth, over the best fit
    /// of other columns: the squared distance of the two predictions, in sigmas.
    pub fn separation(
        &self,
        sums: &NormalEquations,
        columns: &[usize],
        values: &[f64],
        others: &[usize],
    ) -> f64 {
        let mut truth = NormalEquations { right: sums.right.scale(0.0), ..sums.clone() };
        for (i, a) in columns.iter().zip(values) {
            truth.right += sums.gram.column(*i) * *a;
        }
        truth.squares = sums.quadratic(columns, &DVector::from_column_slice(values));
        let mut flat = Self { priors: self.priors.clone(), folds: Vec::new(), total: truth };
        flat.priors.iter_mut().for_each(|prior| prior.from_middle = 0.0);
        let delta = flat.best(&flat.total, others);
        flat.total.chi_squared(others, &delta)
    }

    /// The sums of all folds but these, given in their order.
    pub fn without(
        &self,
        left_out: impl IntoIterator<Item = usize>,
    ) -> EquationsWithout<'_, NormalEquations> {
        let folds = left_out.into_iter().map(|fold| &self.folds[fold].sums);
        EquationsWithout::new(&self.total, folds.collect())
    }

    /// The folds of a run, which stand together.
    pub fn folds_of(&self, run: usize) -> Range<usize> {
        let before = |end: usize| self.folds.partition_point(|fold| fold.run < end);
        before(run)..before(run + 1)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::estimation::normal_equations::Columns;
    use crate::numeric::random::Random;

    /// Five folds of rows drawn at random in four columns.
    fn drawn() -> CampaignEquations {
        let mut random = Random::new(3);
        let mut total = NormalEquations::zeros(4);
        let folds = (0..5).map(|run| {
            let rows = DMatrix::from_fn(9, 4, |_, _| random.normal());
            let left = DVector::from_fn(9, |_, _| random.normal());
            let sums = NormalEquations {
                gram: Arc::new(rows.transpose() * &rows),
                right: rows.transpose() * &left,
                squares: left.norm_squared(),
                rows: 9.0,
            };
            total.add(&sums);
            Fold { run, kind: RunKind::Straight, sums, blocks: Vec::new() }
        });
        let folds = folds.collect();
        let priors = (0..4).map(|i| Prior { from_middle: 0.3, spread: 0.5 + f64::from(i) });
        CampaignEquations { folds, total, priors: priors.collect() }
    }

    #[test]
    fn values_alone_are_those_of_the_whole_solution() {
        let equations = drawn();
        for columns in [&[0, 1, 2, 3][..], &[3, 1], &[2], &[]] {
            let apart = equations.best(&equations.total, columns)
                - equations.solve(&equations.total, columns).delta;
            assert!(apart.amax() < 1e-12, "{columns:?}: {apart}");
        }
    }

    #[test]
    fn columns_added_up_once_are_those_of_the_sums_in_any_order() {
        let equations = drawn();
        let less = equations.without([1, 4]);
        let columns = [3, 0, 2];
        let once = Columns::of(&less, &columns);
        assert_eq!(equations.best(&once, &columns), equations.best(&less, &columns));
        let delta = DVector::from_vec(vec![0.1, -0.2, 0.3]);
        assert_eq!(once.chi_squared(&columns, &delta), less.chi_squared(&columns, &delta));
    }

    #[test]
    fn a_copy_about_another_point_leaves_the_original_as_it_is() {
        let equations = drawn();
        let before = equations.total.clone();
        let mut moved = equations.clone();
        moved.shift(2, 0.7);
        moved.total.add(&before);
        assert_eq!((&equations.total.gram, &equations.total.right), (&before.gram, &before.right));
        assert!(moved.total.gram != before.gram);
    }
}
