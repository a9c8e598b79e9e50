//! Which effects are worth a fit? To first order about a model: an effect's columns beside those of the model.

use nalgebra::{DMatrix, DVector};

use super::least_squares::{Fitted, Model, Problem};
use super::modes::Modes;
use super::simulate::BASELINE;
use crate::drivetrain::effect::{Excitation, KnownMotorEffect, MotorEffect, MotorRole};
use crate::numeric::parallel;

/// Columns are differences over this share of a usual amplitude.
const STEP: f64 = 0.3;

/// Of an effect with more shapes than this, the best by the columns of the first model get columns of their own.
const SHAPES: usize = 3;

/// An effect that is not in the model, at the best of its shapes.
pub(super) struct Candidate {
    pub effect: KnownMotorEffect,
    /// Its parameters, to first order.
    pub p: Vec<f64>,
    /// What would be left of each experiment, predicted by the others, by mode \[m^2\].
    pub costs: Vec<Modes>,
    /// How the travel of each experiment changes with its amplitudes.
    columns: Vec<DMatrix<f64>>,
}

/// What is screened, and the columns of effects with many shapes about the first model: they hardly change with the others.
pub(super) struct Screen {
    pub excitation: Excitation,
    /// The effects that may be missing.
    catalogue: Vec<KnownMotorEffect>,
    /// The modes' weights in those columns.
    weights: Modes,
    /// By effect with many shapes: its id, each shape with its columns.
    first: Vec<(String, Vec<Shape>)>,
}

/// The parameters of a shape, and its columns.
type Shape = (Vec<f64>, Vec<DMatrix<f64>>);

impl Screen {
    /// With columns about this model.
    pub fn new(
        problem: &Problem<'_>,
        fitted: &Fitted,
        (excitation, catalogue): (Excitation, &[KnownMotorEffect]),
    ) -> Self {
        let many = catalogue.iter().filter_map(|effect| {
            let starts = effect.starts(&excitation);
            (starts.len() > SHAPES).then(|| {
                let shapes = starts.into_iter().map(|start| {
                    let columns = columns(problem, fitted, effect, &start);
                    (start, columns)
                });
                (effect.facts().id.to_owned(), shapes.collect())
            })
        });
        let first = many.collect();
        Self { excitation, catalogue: catalogue.to_vec(), weights: problem.weights, first }
    }

    /// A candidate for each effect that may be missing and is not in the model, best first.
    pub fn candidates(&self, problem: &Problem<'_>, fitted: &Fitted) -> Vec<Candidate> {
        let missing = self.catalogue.iter().filter(|effect| {
            let id = effect.facts().id;
            fitted.model.effects.iter().all(|own| own.facts().id != id)
        });
        let mut found: Vec<Candidate> = missing
            .filter_map(|effect| {
                let starts = self.starts(problem, fitted, effect);
                let tried = starts.iter().filter_map(|start| {
                    let columns = columns(problem, fitted, effect, start);
                    candidate(problem, fitted, effect, start, columns)
                });
                tried.min_by(|a, b| {
                    problem.weighted(&a.costs).total_cmp(&problem.weighted(&b.costs))
                })
            })
            .collect();
        found.sort_by(|a, b| problem.weighted(&a.costs).total_cmp(&problem.weighted(&b.costs)));
        found
    }

    /// The shapes that are worth columns of their own.
    fn starts(
        &self,
        problem: &Problem<'_>,
        fitted: &Fitted,
        effect: &KnownMotorEffect,
    ) -> Vec<Vec<f64>> {
        let Some((_, shapes)) = self.first.iter().find(|(id, _)| *id == effect.facts().id) else {
            return effect.starts(&self.excitation);
        };
        let scale = problem.weights.zip(self.weights, |now, first| (now / first).sqrt());
        let mut ranked: Vec<(f64, &Vec<f64>)> = shapes
            .iter()
            .filter_map(|(start, columns)| {
                let columns = columns.iter().map(|columns| scale.times(columns)).collect();
                let found = candidate(problem, fitted, effect, start, columns)?;
                Some((problem.weighted(&found.costs), start))
            })
            .collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        ranked.into_iter().take(SHAPES).map(|(_, start)| start.clone()).collect()
    }
}

/// Two effects together: their columns beside each other.
pub(super) fn pair_costs(
    problem: &Problem<'_>,
    fitted: &Fitted,
    (one, other): (&Candidate, &Candidate),
) -> Option<Vec<Modes>> {
    let both: Vec<DMatrix<f64>> = one
        .columns
        .iter()
        .zip(&other.columns)
        .map(|(one, other)| {
            let mut both = one.clone().resize_horizontally(one.ncols() + other.ncols(), 0.0);
            both.columns_mut(one.ncols(), other.ncols()).copy_from(other);
            both
        })
        .collect();
    let usual: Vec<f64> =
        [one, other].into_iter().flat_map(|one| amplitudes(&*one.effect)).map(|a| a.1).collect();
    linear_cross_validation(problem, fitted, &both, &usual).map(|found| found.1)
}

/// The amplitudes of an effect: which of its parameters, and their usual sizes.
fn amplitudes(effect: &dyn MotorEffect) -> Vec<(usize, f64)> {
    let parameters = effect.facts().parameters.iter().enumerate();
    parameters
        .filter(|(_, parameter)| parameter.role == MotorRole::Amplitude)
        .map(|(i, parameter)| (i, parameter.usual))
        .collect()
}

/// How the travel of each experiment changes with the amplitudes of an effect, from zero on, at a shape.
fn columns(
    problem: &Problem<'_>,
    fitted: &Fitted,
    effect: &KnownMotorEffect,
    start: &[f64],
) -> Vec<DMatrix<f64>> {
    let first = fitted.model.at.len();
    let grown: Vec<(Model, f64)> = amplitudes(&**effect)
        .into_iter()
        .map(|(i, usual)| {
            let mut model = fitted.model.with(effect.clone(), start);
            model.at[first + i] = STEP * usual;
            (model, STEP * usual)
        })
        .collect();
    added_columns(problem, fitted, &grown)
}

/// None if its amplitude would have the wrong sign.
fn candidate(
    problem: &Problem<'_>,
    fitted: &Fitted,
    effect: &KnownMotorEffect,
    start: &[f64],
    columns: Vec<DMatrix<f64>>,
) -> Option<Candidate> {
    let parameters = effect.facts().parameters;
    let (amplitudes, usual): (Vec<usize>, Vec<f64>) = amplitudes(&**effect).into_iter().unzip();
    let (best, costs) = linear_cross_validation(problem, fitted, &columns, &usual)?;
    let mut p = start.to_vec();
    for (value, &i) in best.iter().zip(&amplitudes) {
        if parameters[i].low == 0.0 && *value <= 0.0 {
            return None;
        }
        p[i] = value.clamp(parameters[i].low, parameters[i].high);
    }
    Some(Candidate { effect: effect.clone(), p, costs, columns })
}

/// How the travel of each experiment changes from the fitted model to others, per amplitude.
pub(super) fn added_columns(
    problem: &Problem<'_>,
    fitted: &Fitted,
    grown: &[(Model, f64)],
) -> Vec<DMatrix<f64>> {
    let indices: Vec<usize> = (0..problem.experiments.len()).collect();
    parallel::map(&indices, |&index| {
        let base = &fitted.residuals[index];
        let mut columns = DMatrix::zeros(base.len(), grown.len());
        for (i, (model, amplitude)) in grown.iter().enumerate() {
            let moved = problem.residuals(model, &model.at, problem.experiments[index]);
            columns.set_column(i, &((base - moved) / *amplitude));
        }
        columns
    })
}

/// Least squares on the model's columns and the added ones: the added amplitudes, and what is left of each experiment when the
/// others predict it.
pub(super) fn linear_cross_validation(
    problem: &Problem<'_>,
    fitted: &Fitted,
    added: &[DMatrix<f64>],
    usual: &[f64],
) -> Option<(Vec<f64>, Vec<Modes>)> {
    let (own, more) = (fitted.model.at.len(), usual.len());
    let len = own + more;
    let (own_gram, _) = fitted.sums(problem);
    let shares_of_own = fitted.shares();
    let prior = own_gram - shares_of_own.iter().fold(DMatrix::zeros(own, own), |s, x| s + &x.gram);
    let columns: Vec<DMatrix<f64>> = fitted
        .columns
        .iter()
        .zip(added)
        .map(|(own, added)| {
            let mut both = own.clone().resize_horizontally(len, 0.0);
            both.columns_mut(own.ncols(), more).copy_from(added);
            both
        })
        .collect();
    let shares: Vec<(DMatrix<f64>, DVector<f64>)> = columns
        .iter()
        .zip(&fitted.residuals)
        .map(|(columns, residuals)| (columns.tr_mul(columns), columns.tr_mul(residuals)))
        .collect();
    let mut gram = DMatrix::zeros(len, len);
    gram.view_mut((0, 0), (own, own)).copy_from(&prior);
    // As weak as the baseline's priors, for amplitudes of a usual size.
    let strength = prior[(0, 0)] * fitted.model.at[0].max(0.05).powi(2);
    for (i, usual) in usual.iter().enumerate() {
        gram[(own + i, own + i)] = strength / (usual * usual);
    }
    let mut gradient = DVector::zeros(len);
    for (share, towards) in &shares {
        gram += share;
        gradient += towards;
    }
    let best = gram.clone().cholesky()?.solve(&gradient);
    let costs = shares
        .iter()
        .zip(columns.iter().zip(&fitted.residuals))
        .map(|((share, towards), (columns, residuals))| {
            let others = (&gram - share).cholesky()?.solve(&(&gradient - towards));
            Some(problem.cost(&(residuals - columns * others)))
        })
        .collect::<Option<Vec<Modes>>>()?;
    debug_assert!(own >= BASELINE);
    Some((best.rows(own, more).iter().copied().collect(), costs))
}
