//! What is missing: the answer, in numbers.

use std::borrow::Cow;

use super::classes::{Rival, rivals};
use super::experiment::{Experiment, KnownRobot, full_v, pause_end_s};
use super::least_squares::{Fitted, Model, Problem};
use super::modes::Modes;
use super::next_experiment::{NextExperiment, next_experiment};
use super::selection::{Judged, Selected, gain_by, select};
use super::simulate::BASELINE;
use super::unexplained::{MotorUnexplained, unexplained};
use crate::drivetrain::effect::KnownMotorEffect;
use crate::drivetrain::regression::regress;
use crate::kinematics::WheelPair;

/// How far a model is off, root mean square over samples and wheels \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorErrors {
    /// Of the experiments that it was fitted to.
    pub fitted_m: f64,
    /// Of each experiment, predicted by the others.
    pub cross_validated_m: f64,
    /// Of those that the user keeps aside, if there are any.
    pub held_out_m: Option<f64>,
}

/// A constant, and how sure it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Its name.
    pub name: Cow<'static, str>,
    /// Its unit.
    pub unit: Cow<'static, str>,
    /// Its value.
    pub value: f64,
    /// Half the width of its 95 % interval; not finite where one experiment alone tells it, 0 where none does.
    pub half_width_95: f64,
    /// It is at the end of the range in which it was looked for.
    pub is_at_end: bool,
}

/// The parameters of one effect of a model.
pub(super) fn estimates(model: &Model, index: usize, half_widths: &[f64]) -> Vec<Estimate> {
    let first = model.first_of(index);
    let parameters = model.effects[index].facts().parameters.iter().enumerate();
    parameters
        .map(|(i, parameter)| {
            let value = model.at[first + i];
            Estimate {
                name: parameter.name.clone(),
                unit: parameter.unit.clone(),
                value,
                half_width_95: half_widths[first + i],
                is_at_end: value != 0.0 && (value == parameter.low || value == parameter.high),
            }
        })
        .collect()
}

/// One effect that is missing.
#[derive(Clone, Debug, PartialEq)]
pub struct MotorStep {
    /// The effect.
    pub effect: KnownMotorEffect,
    /// Those that these experiments cannot tell from it, best first.
    pub class: Vec<KnownMotorEffect>,
    /// Its parameters in the final model.
    pub parameters: Vec<Estimate>,
    /// The errors with it and those before it.
    pub errors: MotorErrors,
    /// Root mean square of what it explains \[m\].
    pub size_m: f64,
    /// How often chance gives as much.
    pub p_value: f64,
}

/// An effect that was tried alone beside the baseline.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    /// The effect.
    pub effect: KnownMotorEffect,
    /// The cross-validated error with it, to first order \[m\].
    pub cross_validated_m: f64,
}

/// What is left of the travel of one experiment, sample by sample: measured less modelled \[m\].
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOfTravel {
    /// By the baseline.
    pub baseline_m: Vec<WheelPair<f64>>,
    /// With the effects that are missing.
    pub with_effects_m: Vec<WheelPair<f64>>,
}

/// What is missing.
#[derive(Clone, Debug, PartialEq)]
pub struct MotorAnswer {
    /// The error without effects.
    pub baseline: MotorErrors,
    /// kS, kV, kA, kC, kD, kW of the final model.
    pub constants: Vec<Estimate>,
    /// The effects that are missing, in the order in which they were found.
    pub steps: Vec<MotorStep>,
    /// Every effect alone, best first.
    pub tried: Vec<Tried>,
    /// What remains.
    pub unexplained: MotorUnexplained,
    /// The experiment that would tell more.
    pub next: Option<NextExperiment>,
    /// What is left of each experiment that is fitted, in their order.
    pub left: Vec<LeftOfTravel>,
    /// How many experiments were fitted.
    pub experiments: usize,
    /// What the counts hide \[m\].
    pub resolution_m: f64,
}

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq)]
pub enum MissingError {
    /// Fewer experiments than can be predicted by others.
    TooFew {
        /// How many there are.
        experiments: usize,
    },
    /// The experiments do not turn both wheels forwards and backwards by their motors.
    NoMotion,
    /// An effect does what the rest of the model can do already.
    Inseparable {
        /// Its id.
        effect: String,
    },
    /// These experiments do not determine an effect: with it each is predicted far worse by the others.
    Unstable {
        /// Its id.
        effect: String,
        /// The cross-validated error without it \[m\].
        before_m: f64,
        /// And with it; not finite where the travel is not \[m\].
        after_m: f64,
    },
}

/// With fewer experiments nothing can be told from chance.
pub const EXPERIMENTS_MIN: usize = 8;

/// Which effects of the catalogue do these motors have, that the baseline lacks?
pub fn missing(
    robot: &KnownRobot,
    experiments: &[Experiment],
) -> Result<MotorAnswer, MissingError> {
    missing_with(robot, experiments, &KnownMotorEffect::all(&[]))
}

/// Which effects of a list do these motors have, that the baseline lacks?
pub fn missing_with(
    robot: &KnownRobot,
    experiments: &[Experiment],
    catalogue: &[KnownMotorEffect],
) -> Result<MotorAnswer, MissingError> {
    let (problem, baseline) = fitted_baseline(robot, experiments)?;
    let selected = select(&problem, baseline, catalogue);
    let problem = &selected.problem;
    let last = &selected.steps[selected.steps.len() - 1];
    let without: Vec<Judged> = (0..last.fitted.model.effects.len())
        .map(|index| {
            let baseline = &selected.steps[0].fitted.model;
            Judged::new(problem, problem.fit_without(&last.fitted.model, index, baseline))
        })
        .collect();
    let rivals: Vec<(&KnownMotorEffect, Vec<Rival>)> = without
        .iter()
        .enumerate()
        .map(|(index, without)| {
            let own = &last.fitted.model.effects[index];
            (own, rivals(problem, &selected, (last, without), index))
        })
        .collect();
    let unexplained = unexplained(problem, &selected, last);
    let half_widths = problem.half_widths_95(&last.fitted);
    let errors = |judged: &Judged| errors(problem, judged, experiments);
    let steps: Vec<MotorStep> = selected
        .steps
        .windows(2)
        .enumerate()
        .map(|(index, pair)| {
            let by_itself = gain_by(problem, &pair[0], &pair[1], index);
            // The first of two that hide each other gains nothing by itself.
            let gain = if by_itself.matters(problem) {
                by_itself
            } else {
                gain_by(problem, &without[index], last, index)
            };
            let effect = &last.fitted.model.effects[index];
            MotorStep {
                effect: effect.clone(),
                class: rivals[index].1.iter().map(|rival| rival.effect.clone()).collect(),
                parameters: estimates(&last.fitted.model, index, &half_widths),
                errors: errors(&pair[1]),
                size_m: gain.size_m,
                p_value: gain.p_value,
            }
        })
        .collect();
    // Which of two small effects it is can wait until what remains is known.
    let least_m = if unexplained.structure { unexplained.size_m } else { 0.0 };
    let asked = rivals.iter().zip(&steps).filter(|(_, step)| step.size_m >= least_m);
    let asked: Vec<_> = asked.map(|(rivals, _)| rivals).collect();
    let next = next_experiment(problem, &last.fitted, &asked, &unexplained);
    Ok(MotorAnswer {
        baseline: errors(&selected.steps[0]),
        constants: constants(&last.fitted.model, &half_widths),
        steps,
        tried: tried(problem, &selected),
        unexplained,
        next,
        left: left_of_travel(problem, &selected.steps[0], last),
        experiments: problem.experiments.len(),
        resolution_m: robot.resolution_m(),
    })
}

/// Each effect beside the baseline, the least error first: the candidates are in the order of their weighted costs.
fn tried(problem: &Problem<'_>, selected: &Selected<'_>) -> Vec<Tried> {
    let tried = selected.alone.iter().map(|candidate| Tried {
        effect: candidate.effect.clone(),
        cross_validated_m: problem.rms_m(&candidate.costs),
    });
    let mut tried: Vec<Tried> = tried.collect();
    tried.sort_by(|a, b| a.cross_validated_m.total_cmp(&b.cross_validated_m));
    tried
}

fn left_of_travel(problem: &Problem<'_>, first: &Judged, last: &Judged) -> Vec<LeftOfTravel> {
    let left = |judged: &Judged, experiment: &Experiment| {
        let model = &judged.fitted.model;
        model.left_of_travel(problem, &model.at, experiment).collect()
    };
    let experiments = problem.experiments.iter();
    experiments
        .map(|experiment| LeftOfTravel {
            baseline_m: left(first, experiment),
            with_effects_m: left(last, experiment),
        })
        .collect()
}

/// The baseline's errors alone.
pub fn baseline_errors(
    robot: &KnownRobot,
    experiments: &[Experiment],
) -> Result<BaselineErrors, MissingError> {
    let (problem, baseline) = fitted_baseline(robot, experiments)?;
    let judged = Judged::new(&problem, baseline);
    let each = judged.costs.iter().enumerate();
    let half_widths = problem.half_widths_95(&judged.fitted);
    Ok(BaselineErrors {
        errors: errors(&problem, &judged, experiments),
        constants: constants(&judged.fitted.model, &half_widths),
        each_m: each.map(|(index, cost)| (cost.sum() / problem.len(index) as f64).sqrt()).collect(),
        resolution_m: robot.resolution_m(),
    })
}

/// How far the baseline is off.
#[derive(Clone, Debug, PartialEq)]
pub struct BaselineErrors {
    /// Over all experiments.
    pub errors: MotorErrors,
    /// kS, kV, kA, kC, kD, kW.
    pub constants: Vec<Estimate>,
    /// Of each experiment that is fitted, predicted by the others, in their order \[m\].
    pub each_m: Vec<f64>,
    /// What the counts hide \[m\].
    pub resolution_m: f64,
}

pub(super) fn fitted_baseline<'a>(
    robot: &'a KnownRobot,
    experiments: &'a [Experiment],
) -> Result<(Problem<'a>, Fitted), MissingError> {
    let fitted: Vec<&Experiment> = experiments.iter().filter(|one| !one.held_out).collect();
    if fitted.len() < EXPERIMENTS_MIN {
        return Err(MissingError::TooFew { experiments: fitted.len() });
    }
    let recordings: Vec<_> = fitted.iter().map(|experiment| experiment.recording.clone()).collect();
    let guess = regress(&recordings).ok_or(MissingError::NoMotion)?;
    let (left, right) = (guess.wheels.left, guess.wheels.right);
    let ks = 0.5 * (left.ks_mean_v() + right.ks_mean_v());
    let kv = 0.5 * (left.kv_v_s_per_m + right.kv_v_s_per_m);
    let ka = 0.5 * (left.ka_v_s2_per_m + right.ka_v_s2_per_m);
    let problem = Problem {
        robot,
        pause_end_s: pause_end_s(&fitted),
        full_v: full_v(&fitted),
        experiments: fitted,
        weights: Modes::EQUAL,
    };
    let at = vec![ks, kv, 0.85 * ka, 0.0, 0.0, 0.0];
    debug_assert_eq!(at.len(), BASELINE);
    let baseline = problem.fit(Model { effects: Vec::new(), at });
    Ok((problem, baseline))
}

pub(super) fn constants(model: &Model, half_widths: &[f64]) -> Vec<Estimate> {
    let names = [
        ("kS", "V"),
        ("kV", "V s/m"),
        ("kA", "V s^2/m"),
        ("kC", "V s^2/m"),
        ("kD", "V s^2/m"),
        ("kW", "V s^2/m^2"),
    ];
    let values = model.at.iter().zip(half_widths);
    let both = names.into_iter().zip(values);
    both.map(|((name, unit), (value, half_width))| Estimate {
        name: Cow::Borrowed(name),
        unit: Cow::Borrowed(unit),
        value: *value,
        half_width_95: *half_width,
        is_at_end: false,
    })
    .collect()
}

pub(super) fn errors(
    problem: &Problem<'_>,
    judged: &Judged,
    experiments: &[Experiment],
) -> MotorErrors {
    let model = &judged.fitted.model;
    let (mut cost, mut samples) = (0.0, 0);
    for experiment in experiments.iter().filter(|experiment| experiment.held_out) {
        let left = problem.residuals(model, &model.at, experiment);
        cost += problem.cost(&left).sum();
        samples += left.len();
    }
    MotorErrors {
        fitted_m: problem.rms_m(&judged.fitted.costs),
        cross_validated_m: problem.rms_m(&judged.costs),
        held_out_m: (samples > 0).then(|| (cost / samples as f64).sqrt()),
    }
}
