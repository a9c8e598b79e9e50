//! What the motors lack, as JSON.

use robot_model::drivetrain::{
    BaselineErrors, ChosenEffect, ChosenModel, Estimate, KnownMotorEffect, MotorAnswer, MotorErrors,
};
use serde_json::{Value, json};

use crate::words::motors::{kind_id, regressor_id};

/// How far the model is off, with the effects that it has.
pub fn motor_comparison(found: &BaselineErrors, names: &[&str], effects: &[&str]) -> Value {
    let each = names.iter().zip(&found.each_m);
    json!({
        "schema": 1,
        "effects": effects,
        "error": motor_errors(&found.errors),
        "resolution_m": found.resolution_m,
        "constants": found.constants.iter().map(estimate).collect::<Vec<_>>(),
        "experiments": each.map(|(name, off_m)| json!({"name": name, "cross_validated_m": off_m})).collect::<Vec<_>>(),
    })
}

/// The effects of a user's model of the motors.
pub fn chosen_effects(model: &ChosenModel) -> Vec<Value> {
    let effect = |effect: &ChosenEffect| {
        json!({
            "effect": effect.effect.facts().id,
            "parameters": motor_estimates(&effect.parameters),
            "needed": effect.matters,
            "p_value": effect.p_value,
            "without_m": effect.without_m,
        })
    };
    model.effects.iter().map(effect).collect()
}

/// Constants of motors.
pub fn motor_estimates(of: &[Estimate]) -> Vec<Value> {
    of.iter().map(estimate).collect()
}

/// What is missing.
pub fn motor_answer(answer: &MotorAnswer, verdict: &str) -> Value {
    let step = |step: &robot_model::drivetrain::MotorStep| {
        json!({
            "effect": step.effect.facts().id,
            "class": ids(&step.class),
            "parameters": step.parameters.iter().map(estimate).collect::<Vec<_>>(),
            "error": motor_errors(&step.errors),
            "size_m": step.size_m,
            "p_value": step.p_value,
            "why": step.effect.facts().name,
        })
    };
    let tried = answer.tried.iter().map(
        |tried| json!({"effect": tried.effect.facts().id, "cross_validated_m": tried.cross_validated_m}),
    );
    let unexplained = &answer.unexplained;
    let depends_on = unexplained.depends_on.iter().map(|by| regressor_id(*by)).collect::<Vec<_>>();
    json!({
        "schema": 1,
        "verdict": verdict,
        "experiments": answer.experiments,
        "resolution_m": answer.resolution_m,
        "baseline": motor_errors(&answer.baseline),
        "constants": answer.constants.iter().map(estimate).collect::<Vec<_>>(),
        "steps": answer.steps.iter().map(step).collect::<Vec<_>>(),
        "tried_alone": tried.collect::<Vec<_>>(),
        "unexplained": {
            "structure": unexplained.structure,
            "depends_on": depends_on,
            "p_value": unexplained.p_value,
            "size_m": unexplained.size_m,
            "floor_m": unexplained.floor_m,
        },
        "next": answer.next.as_ref().map(|next| json!({
            "kind": kind_id(next.kind),
            "separates": ids(&next.separates),
            "apart_m": next.apart_m,
        })),
    })
}

/// Errors of a model of the motors.
pub fn motor_errors(errors: &MotorErrors) -> Value {
    json!({
        "fitted_m": errors.fitted_m,
        "cross_validated_m": errors.cross_validated_m,
        "held_out_m": errors.held_out_m,
    })
}

fn ids(effects: &[KnownMotorEffect]) -> Vec<&str> {
    effects.iter().map(|effect| effect.facts().id).collect()
}

fn estimate(estimate: &Estimate) -> Value {
    let Estimate { name, unit, value, half_width_95, is_at_end } = estimate;
    // 0: nothing is known.
    let half_width_95 =
        (half_width_95.is_finite() && *half_width_95 > 0.0).then_some(half_width_95);
    json!({
        "name": name,
        "unit": unit,
        "value": value,
        "half_width_95": half_width_95,
        "is_at_end_of_range": is_at_end,
    })
}
