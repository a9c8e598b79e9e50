//! Which effects are worth a fit? To first order about a model: an effect's columns beside those of the model.

use nalgebra::{DMatrix, DVector};

use super::least_squares::{Fitted, Model, Problem};
use super::modes::Modes;
use super::simulate::BASELINE;
use crate::drivetrain::effect::{Excitation, MotorEffect, MotorRole};
use crate::numeric::parallel;

/// Columns are differences over this share of a usual amplitude.
const STEP: f64 = 0.3;

/// An effect that is not in the model, at the best of its shapes.
pub(super) struct Candidate {
    pub effect: &'static dyn MotorEffect,
    /// Its parameters, to first order.
    pub p: Vec<f64>,
    /// What would be left of each experiment, predicted by the others, by mode \[m^2\].
    pub costs: Vec<Modes>,
}

/// A candidate for each effect of a catalogue that is not in the model, best first.
pub(super) fn screen(
    problem: &Problem<'_>,
    fitted: &Fitted,
    catalogue: &[&'static dyn MotorEffect],
    excitation: &Excitation,
) -> Vec<Candidate> {
    let missing = catalogue.iter().filter(|effect| {
        let id = effect.facts().id;
        fitted.model.effects.iter().all(|own| own.facts().id != id)
    });
    let of = |effect: &&'static dyn MotorEffect| {
        let starts = effect.starts(excitation);
        let tried = starts.iter().filter_map(|start| candidate(problem, fitted, *effect, start));
        tried.min_by(|a, b| problem.weighted(&a.costs).total_cmp(&problem.weighted(&b.costs)))
    };
    let mut found: Vec<Candidate> = missing.filter_map(of).collect();
    found.sort_by(|a, b| problem.weighted(&a.costs).total_cmp(&problem.weighted(&b.costs)));
    found
}

/// None if its amplitude would have the wrong sign.
fn candidate(
    problem: &Problem<'_>,
    fitted: &Fitted,
    effect: &'static dyn MotorEffect,
    start: &[f64],
) -> Option<Candidate> {
    let parameters = effect.facts().parameters;
    let amplitudes: Vec<usize> =
        (0..parameters.len()).filter(|i| parameters[*i].role == MotorRole::Amplitude).collect();
    let first = fitted.model.at.len();
    let grown = amplitudes
        .iter()
        .map(|&i| {
            let mut model = fitted.model.with(effect, start);
            model.at[first + i] = STEP * parameters[i].usual;
            (model, STEP * parameters[i].usual)
        })
        .collect::<Vec<_>>();
    let added = added_columns(problem, fitted, &grown);
    let ridge: Vec<f64> = amplitudes.iter().map(|&i| parameters[i].usual).collect();
    let (best, costs) = linear_cross_validation(problem, fitted, &added, &ridge)?;
    let mut p = start.to_vec();
    for (value, &i) in best.iter().zip(&amplitudes) {
        if parameters[i].low == 0.0 && *value <= 0.0 {
            return None;
        }
        p[i] = value.clamp(parameters[i].low, parameters[i].high);
    }
    Some(Candidate { effect, p, costs })
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
