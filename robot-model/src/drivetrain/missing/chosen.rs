//! The model with effects that a user has chosen: does it predict these motors better with them?

use super::answer::{
    BaselineErrors, Estimate, MissingError, MotorErrors, constants, errors, fitted_baseline,
};
use super::experiment::{Experiment, KnownRobot, excitation};
use super::screening::Screen;
use super::selection::{Judged, gain_by};
use crate::drivetrain::effect::KnownMotorEffect;

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
    let screen =
        Screen::new(&problem, &judged.fitted, (excitation(robot, &problem.experiments), effects));
    for effect in effects {
        let candidates = screen.candidates(&problem, &judged.fitted);
        let id = effect.facts().id;
        let start = candidates.into_iter().find(|candidate| candidate.effect.facts().id == id);
        // What these experiments do not show at all stays zero.
        let start = start.map_or_else(|| vec![0.0; effect.facts().parameters.len()], |it| it.p);
        let fitted = problem.fit(judged.fitted.model.with(effect.clone(), &start));
        (problem, judged) = Judged::reweighted(&problem, fitted);
    }
    let half_widths = problem.half_widths_95(&judged.fitted);
    let model = &judged.fitted.model;
    let chosen = effects.iter().enumerate().map(|(index, effect)| {
        let without = Judged::new(&problem, problem.fit(model.without(index)));
        let gain = gain_by(&problem, &without, &judged, index);
        let first = model.first_of(index);
        let parameters = effect.facts().parameters.iter().enumerate();
        ChosenEffect {
            effect: effect.clone(),
            parameters: parameters
                .map(|(i, parameter)| Estimate {
                    name: parameter.name.clone(),
                    unit: parameter.unit.clone(),
                    value: model.at[first + i],
                    half_width_95: half_widths[first + i],
                })
                .collect(),
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
