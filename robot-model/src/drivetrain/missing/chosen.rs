//! The model with effects that a user has chosen: does it predict these motors better with them?

use nalgebra::{DMatrix, DVector};

use super::answer::{
    BaselineErrors, Estimate, MissingError, MotorErrors, constants, errors, estimates,
    fitted_baseline,
};
use super::experiment::{Experiment, KnownRobot, excitation};
use super::least_squares::Fitted;
use super::screening::Screen;
use super::selection::{Judged, gain_by};
use crate::drivetrain::effect::{KnownMotorEffect, MotorRole};

/// With an effect that these experiments do not determine, each is predicted so many times worse by the others.
const UNSTABLE: f64 = 2.0;
/// An amplitude whose travel the rest of the model has already, but for this share of its square, is no parameter of its own.
const SHARE_OF_ITS_OWN: f64 = 1e-4;

/// Whether an amplitude of an effect does what the baseline and the other effects can do already.
fn is_told_already(fitted: &Fitted, index: usize) -> bool {
    let model = &fitted.model;
    let first = model.first_of(index);
    let shares = fitted.shares();
    let mut gram = shares[0].gram.clone();
    shares[1..].iter().for_each(|share| gram += &share.gram);
    let scale: Vec<f64> = (0..gram.nrows()).map(|i| gram[(i, i)].sqrt()).collect();
    let parameters = model.effects[index].facts().parameters.iter().enumerate();
    parameters.filter(|(_, one)| one.role == MotorRole::Amplitude).any(|(i, _)| {
        let own = first + i;
        // What these experiments do not show, or the model did not have before.
        let others: Vec<usize> = (0..first).filter(|other| scale[*other] > 0.0).collect();
        if scale[own] == 0.0 {
            return false;
        }
        let cosine = |a: usize, b: usize| gram[(a, b)] / (scale[a] * scale[b]);
        let len = others.len();
        let among = DMatrix::from_fn(len, len, |a, b| {
            // So little that columns which are alike themselves do no harm.
            cosine(others[a], others[b]) + if a == b { 1e-9 } else { 0.0 }
        });
        let with = DVector::from_fn(len, |a, _| cosine(others[a], own));
        let told = among.cholesky().map_or(0.0, |factor| factor.solve(&with).dot(&with));
        1.0 - told < SHARE_OF_ITS_OWN
    })
}

/// An effect of a user's model.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenEffect {
    /// The effect.
    pub effect: KnownMotorEffect,
    /// Its parameters.
    pub parameters: Vec<Estimate>,
    /// Beside the others it predicts the experiments better than chance would, and by a size worth a word.
    pub matters: bool,
    /// How often chance gives as much.
    pub p_value: f64,
    /// The error without it, each experiment predicted by the others \[m\].
    pub without_m: f64,
}

/// A user's model, fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct ChosenModel {
    /// Over all experiments.
    pub errors: MotorErrors,
    /// kS, kV, kA, kC, kD, kW.
    pub constants: Vec<Estimate>,
    /// The effects, in the order given.
    pub effects: Vec<ChosenEffect>,
    /// Of each experiment that is fitted, predicted by the others, in their order \[m\].
    pub each_m: Vec<f64>,
    /// What the counts hide \[m\].
    pub resolution_m: f64,
}

impl From<ChosenModel> for BaselineErrors {
    fn from(model: ChosenModel) -> Self {
        let ChosenModel { errors, constants, each_m, resolution_m, .. } = model;
        Self { errors, constants, each_m, resolution_m }
    }
}

/// Fits the model with these effects, one after the other and then all together.
pub fn fit_chosen(
    robot: &KnownRobot,
    experiments: &[Experiment],
    effects: &[KnownMotorEffect],
) -> Result<ChosenModel, MissingError> {
    let (problem, baseline) = fitted_baseline(robot, experiments)?;
    let (mut problem, mut judged) = Judged::reweighted(&problem, baseline);
    let first = judged.fitted.model.clone();
    let screen =
        Screen::new(&problem, &judged.fitted, (excitation(robot, &problem.experiments), effects));
    for effect in effects {
        let candidates = screen.candidates(&problem, &judged.fitted);
        let id = effect.facts().id;
        let start = candidates.into_iter().find(|candidate| candidate.effect.facts().id == id);
        // What these experiments do not show at all stays zero.
        let start = start.map_or_else(|| vec![0.0; effect.facts().parameters.len()], |it| it.p);
        let fitted = problem.fit_with(&judged.fitted, effect, &start);
        let before = judged.clone();
        let before_m = problem.rms_m(&before.costs);
        (problem, judged) = Judged::reweighted(&problem, fitted);
        let index = judged.fitted.model.effects.len() - 1;
        // Of an effect that is large, what little the rest cannot do may be much.
        let matters = gain_by(&problem, &before, &judged, index).matters(&problem);
        if !matters && is_told_already(&judged.fitted, index) {
            return Err(MissingError::Inseparable { effect: id.to_owned() });
        }
        let after_m = problem.rms_m(&judged.costs);
        if !after_m.is_finite() || after_m > UNSTABLE * before_m {
            let effect = id.to_owned();
            return Err(MissingError::Unstable { effect, before_m, after_m });
        }
    }
    let half_widths = problem.half_widths_95(&judged.fitted);
    let model = &judged.fitted.model;
    let chosen = effects.iter().enumerate().map(|(index, effect)| {
        let without = Judged::new(&problem, problem.fit_without(model, index, &first));
        let gain = gain_by(&problem, &without, &judged, index);
        ChosenEffect {
            effect: effect.clone(),
            parameters: estimates(model, index, &half_widths),
            matters: gain.matters(&problem),
            p_value: gain.p_value,
            without_m: problem.rms_m(&without.costs),
        }
    });
    let each = judged.costs.iter().enumerate();
    Ok(ChosenModel {
        errors: errors(&problem, &judged, experiments),
        constants: constants(model, &half_widths),
        effects: chosen.collect(),
        each_m: each.map(|(index, cost)| (cost.sum() / problem.len(index) as f64).sqrt()).collect(),
        resolution_m: robot.resolution_m(),
    })
}
