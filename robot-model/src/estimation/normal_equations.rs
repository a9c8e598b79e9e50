//! What do the runs of a campaign tell about any set of parameters? Normal equations, one set for each run.
//!
//! After whitening, with rows (r, J) about one point of all parameters, each run is
//!
//! ```text
//! A = J'J,  b = J'r,  c = r'r;      chi^2(d) = c - 2 b'd + d'A d                     (1)
//! ```
//!
//! and every refit, cross-validation and test after that is arithmetic on sums of these over runs. The run is the
//! unit throughout: samples of one run share its accidents. Which columns to fit is the caller's question.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::effect::composition::{PlacedTerm, Terms};
use crate::effect::definition::Role;
use crate::estimation::ekf::{Innovation, Sink, whiten};
use crate::estimation::gyro::whiten_gyro;
use crate::recording::campaign::Prepared;
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::run_kind::RunKind;

/// A single run is cut into this many blocks, so that it can be cross-validated.
const BLOCKS: usize = 8;

/// Equation (1) of some rows.
#[derive(Clone, Debug)]
pub(crate) struct NormalEquations {
    pub gram: DMatrix<f64>,
    pub right: DVector<f64>,
    pub squares: f64,
    pub rows: f64,
}

impl NormalEquations {
    pub fn zeros(columns: usize) -> Self {
        Self {
            gram: DMatrix::zeros(columns, columns),
            right: DVector::zeros(columns),
            squares: 0.0,
            rows: 0.0,
        }
    }

    pub fn add(&mut self, other: &Self) {
        self.gram += &other.gram;
        self.right += &other.right;
        self.squares += other.squares;
        self.rows += other.rows;
    }

    /// The same sums about a point that differs in one column by `delta`.
    fn shift(&mut self, column: usize, delta: f64) {
        self.squares += delta * (delta * self.gram[(column, column)] - 2.0 * self.right[column]);
        self.right -= self.gram.column(column) * delta;
    }
}

/// Sums as in (1), of which a fit asks the columns that it needs.
pub(crate) trait Sums {
    fn gram(&self, row: usize, column: usize) -> f64;
    fn right(&self, row: usize) -> f64;
    fn squares(&self) -> f64;

    /// chi^2 of (1) after moving these columns by `delta`.
    fn chi_squared(&self, columns: &[usize], delta: &DVector<f64>) -> f64 {
        let linear: f64 = columns.iter().zip(delta).map(|(i, d)| self.right(*i) * d).sum();
        self.squares() - 2.0 * linear + self.quadratic(columns, delta)
    }

    /// d'A d of (1): how far apart predictions are that differ by `delta`, in sigmas squared.
    fn quadratic(&self, columns: &[usize], delta: &DVector<f64>) -> f64 {
        let mut sum = 0.0;
        for (i, a) in columns.iter().enumerate() {
            for (j, b) in columns.iter().enumerate() {
                sum += delta[i] * self.gram(*a, *b) * delta[j];
            }
        }
        sum
    }
}

impl Sums for NormalEquations {
    fn gram(&self, row: usize, column: usize) -> f64 {
        self.gram[(row, column)]
    }

    fn right(&self, row: usize) -> f64 {
        self.right[row]
    }

    fn squares(&self) -> f64 {
        self.squares
    }
}

/// Some sums less others. Taken column by column when asked for: a copy of all columns for each run that is left
/// out takes longer than the fit.
pub(crate) struct Less<'a, S> {
    all: &'a NormalEquations,
    less: Vec<&'a S>,
}

impl<'a, S: Sums> Less<'a, S> {
    pub fn new(all: &'a NormalEquations, less: Vec<&'a S>) -> Self {
        Self { all, less }
    }
}

impl<S: Sums> Sums for Less<'_, S> {
    fn gram(&self, row: usize, column: usize) -> f64 {
        self.less
            .iter()
            .fold(self.all.gram[(row, column)], |sum, less| sum - less.gram(row, column))
    }

    fn right(&self, row: usize) -> f64 {
        self.less.iter().fold(self.all.right[row], |sum, less| sum - less.right(row))
    }

    fn squares(&self) -> f64 {
        self.less.iter().fold(self.all.squares, |sum, less| sum - less.squares())
    }
}

/// One unit: a run, or a block of it where there is only one run.
#[derive(Clone, Debug)]
pub(crate) struct Unit {
    pub run: usize,
    pub kind: RunKind,
    pub sums: NormalEquations,
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
    pub units: Vec<Unit>,
    pub total: NormalEquations,
    pub priors: Vec<Prior>,
}

/// Values and covariance of some columns.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    pub delta: DVector<f64>,
    pub covariance: DMatrix<f64>,
}

/// Adds rows up, in the block that their step belongs to.
struct Adder {
    columns: usize,
    steps: usize,
    blocks: Vec<(Vec<f64>, Vec<f64>, f64, f64)>,
}

impl Sink for Adder {
    fn row(&mut self, innovation: Innovation, row: &[f64]) {
        let count = self.blocks.len();
        let index = (innovation.step * count / self.steps).min(count - 1);
        let (gram, right, squares, rows) = &mut self.blocks[index];
        let residual = innovation.value / innovation.variance.sqrt();
        for (i, a) in row.iter().enumerate() {
            if *a == 0.0 {
                continue;
            }
            right[i] += a * residual;
            let line = &mut gram[i * self.columns..(i + 1) * self.columns];
            for (slot, b) in line[i..].iter_mut().zip(&row[i..]) {
                *slot += a * b;
            }
        }
        *squares += residual * residual;
        *rows += 1.0;
    }
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
        let blocks = if prepared.runs.len() == 1 { BLOCKS } else { 1 };
        let gathered = crate::numeric::parallel::map(&prepared.runs, |run| {
            let empty = (vec![0.0; columns * columns], vec![0.0; columns], 0.0, 0.0);
            let steps = run.motion.steps.len().max(1);
            let mut adder = Adder { columns, steps, blocks: vec![empty; blocks] };
            whiten(&run.motion, &run.recording.measured_poses, free, noise, &mut adder);
            whiten_gyro(run, free, noise, &mut adder);
            adder.blocks
        });
        let mut units = Vec::new();
        let mut total = NormalEquations::zeros(columns);
        for (index, blocks) in gathered.into_iter().enumerate() {
            for (gram, right, squares, rows) in blocks {
                let mut gram = DMatrix::from_row_slice(columns, columns, &gram);
                gram.fill_lower_triangle_with_upper_triangle();
                let sums = NormalEquations { gram, right: DVector::from_vec(right), squares, rows };
                total.add(&sums);
                if rows > 0.0 {
                    units.push(Unit { run: index, kind: prepared.runs[index].kind, sums });
                }
            }
        }
        Self { units, total, priors: priors(terms) }
    }

    /// Moves the point of linearisation in one column.
    pub fn shift(&mut self, column: usize, delta: f64) {
        self.total.shift(column, delta);
        for unit in &mut self.units {
            unit.sums.shift(column, delta);
        }
        self.priors[column].from_middle += delta;
    }

    /// The best values of these columns by these sums, with the others fixed.
    pub fn solve(&self, sums: &impl Sums, columns: &[usize]) -> Solution {
        let n = columns.len();
        let spread = |i: usize| self.priors[columns[i]].spread;
        // In units of the spreads, so that all numbers are comparable and the prior is the identity.
        let mut matrix = DMatrix::from_fn(n, n, |i, j| {
            spread(i) * sums.gram(columns[i], columns[j]) * spread(j)
        });
        let mut right = DVector::from_fn(n, |i, _| spread(i) * sums.right(columns[i]));
        for i in 0..n {
            let prior = self.priors[columns[i]];
            matrix[(i, i)] += 1.0;
            right[i] -= prior.from_middle / prior.spread;
        }
        let inverse =
            matrix.cholesky().map_or_else(|| DMatrix::identity(n, n), |factor| factor.inverse());
        let delta = DVector::from_fn(n, |i, _| spread(i) * (inverse.row(i) * &right)[0]);
        let covariance = DMatrix::from_fn(n, n, |i, j| spread(i) * inverse[(i, j)] * spread(j));
        Solution { delta, covariance }
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
        let mut flat = Self { priors: self.priors.clone(), units: Vec::new(), total: truth };
        flat.priors.iter_mut().for_each(|prior| prior.from_middle = 0.0);
        let delta = flat.solve(&flat.total, others).delta;
        flat.total.chi_squared(others, &delta)
    }

    /// The sums of all units but these, given in their order.
    pub fn without(&self, left_out: impl IntoIterator<Item = usize>) -> Less<'_, NormalEquations> {
        let units = left_out.into_iter().map(|unit| &self.units[unit].sums);
        Less::new(&self.total, units.collect())
    }

    /// The units of a run, which stand together.
    pub fn units_of(&self, run: usize) -> Range<usize> {
        let before = |end: usize| self.units.partition_point(|unit| unit.run < end);
        before(run)..before(run + 1)
    }
}
