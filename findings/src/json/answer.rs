//! What `explain` answers, schema 2.

use std::path::Path;

use campaign::{Campaign, CampaignError, Recordings};
use robot_model::checks::{DataFault, DataHypothesis};
use robot_model::clocks::ClockFound;
use robot_model::estimation::{ErrorPair, Errors};
use robot_model::explain::{Answer, Averaged, NextRun, ParameterFound, Rejected, StepFound};
use robot_model::residuals::{DrivenAgain, Expression, Regressor, SuddenMotion, Unexplained};
use serde_json::{Value, json};

use crate::words;

/// The whole answer; `verdict` is its first sentences, `data` what is wrong with the data ([`data_hypotheses`]).
pub fn answer(answer: &Answer, verdict: &str, data: &[Value]) -> Value {
    let mut value = json!({
        "schema": 2,
        "verdict": verdict,
        "data_hypotheses": data,
        "floor": errors(&answer.reachable),
        "tolerance_m": answer.tolerance_m,
        "clocks": answer.clocks.iter().map(clock).collect::<Vec<_>>(),
        "baseline": pair(&answer.baseline),
        "steps": steps(&answer.steps),
        "fitted_along": answer.fitted_along.iter().map(along).collect::<Vec<_>>(),
        "rejected": answer.rejected.iter().map(rejected).collect::<Vec<_>>(),
        "unexplained": unexplained(&answer.unexplained),
        "next_run": answer.next_run.as_ref().map(next_run),
    });
    if let Some(off) = &answer.set_aside {
        value["set_aside"] = json!({"runs": answer.unexplained.runs_off, "error": errors(off)});
    }
    value
}

/// Errors on the runs fitted to, and cross-validated.
pub fn pair(pair: &ErrorPair) -> Value {
    json!({"train": errors(&pair.fitted), "heldout": errors(&pair.cross_validated)})
}

/// How far predicted and measured tracks lie apart.
pub fn errors(errors: &Errors) -> Value {
    json!({
        "position_rms_m": errors.position_rms_m,
        "heading_rms_rad": errors.heading_rms_rad,
        "chi": errors.chi,
    })
}

/// The parameters of an effect.
pub fn parameters(parameters: &[ParameterFound]) -> Value {
    let parameter = |of: &ParameterFound| {
        json!({
            "name": of.name,
            "unit": of.unit,
            "value": of.value,
            "sigma": of.sigma,
            "low95": of.low95,
            "high95": of.high95,
        })
    };
    parameters.iter().map(parameter).collect()
}

fn along(found: &Averaged) -> Value {
    json!({"effect": found.effect, "parameters": parameters(&found.parameters)})
}

/// Effects that a model has already, or that are found.
pub fn steps(steps: &[StepFound]) -> Value {
    steps.iter().map(step).collect()
}

fn step(step: &StepFound) -> Value {
    json!({
        "effect": step.effect,
        "class": step.class,
        "parameters": parameters(&step.parameters),
        "train": errors(&step.fitted),
        "heldout": errors(&step.cross_validated),
        "p_value": step.p_value,
        "why": words::evidence(step),
        "matters": step.matters,
        "used_to_predict": step.used_to_predict,
        "effect_size_m": step.effect_size_m,
    })
}

/// What is wrong with the data of a campaign without keeping a fit from being made. `folder` is only named.
pub fn data_hypotheses(read: &Campaign, recordings: &Recordings, folder: &Path) -> Vec<Value> {
    let told = recordings.data_errors(read, folder);
    let found = recordings.data_hypotheses().iter().zip(&told);
    found.map(|(found, told)| data_hypothesis(found, told)).collect()
}

/// What may be wrong with the data: in words, and its evidence.
fn data_hypothesis(found: &DataHypothesis, told: &CampaignError) -> Value {
    json!({
        "id": id(&found.what),
        "run": found.run,
        "evidence": told.problem,
        "mend": told.hint,
        "error_m": found.error_m,
        "mended_m": found.mended_m,
    })
}

/// `CounterWraps { .. }` is `counter_wraps`.
fn id(what: &DataFault) -> String {
    let name = format!("{what:?}");
    let name = name.split([' ', '{', '(']).next().unwrap_or_default();
    let letter = |(k, c): (usize, char)| match c.is_ascii_uppercase() && k > 0 {
        true => format!("_{}", c.to_ascii_lowercase()),
        false => c.to_ascii_lowercase().to_string(),
    };
    name.chars().enumerate().map(letter).collect()
}

fn clock(clock: &ClockFound) -> Value {
    json!({
        "run": clock.run,
        "offset_s": clock.offset_s,
        "offset_sigma_s": clock.offset_sigma_s,
        "rate": clock.rate,
        "rate_sigma": clock.rate_sigma,
    })
}

fn rejected(rejected: &Rejected) -> Value {
    json!({
        "effect": rejected.effect,
        "reason": words::reason(&rejected.reason),
        "heldout": errors(&rejected.cross_validated),
    })
}

fn unexplained(unexplained: &Unexplained) -> Value {
    let names = unexplained.depends_on.iter().copied().map(Regressor::name);
    let mut value = json!({
        "structure": unexplained.structure,
        "depends_on": names.collect::<Vec<_>>(),
        "p_value": unexplained.p_value,
        "size_m": unexplained.size_m,
        "expression": unexplained.expression.as_ref().map(expression),
    });
    if !unexplained.runs_off.is_empty() {
        value["runs_off"] = json!(unexplained.runs_off);
    }
    if !unexplained.sudden.is_empty() {
        value["sudden"] = json!(unexplained.sudden.iter().map(sudden).collect::<Vec<_>>());
    }
    if unexplained.outliers {
        value["outliers"] = json!(true);
    }
    if !unexplained.slight.is_empty() {
        let names = unexplained.slight.iter().copied().map(Regressor::name);
        value["slight"] = json!(names.collect::<Vec<_>>());
    }
    match unexplained.driven_again {
        DrivenAgain::TooFew => {}
        DrivenAgain::Differ => value["comes_back_m"] = json!(0.0),
        DrivenAgain::ComesBack(position_rms_m) => value["comes_back_m"] = json!(position_rms_m),
    }
    if let Some(turn_rad) = unexplained.random_turn_rad {
        value["random_turn_rad"] = json!(turn_rad);
    }
    value
}

fn sudden(found: &SuddenMotion) -> Value {
    let [left_m, right_m] = found.wheels_m;
    json!({
        "run": found.run,
        "from_s": found.from_s,
        "to_s": found.to_s,
        "turn_rad": found.turn_rad,
        "turn_sigma_rad": found.turn_sigma_rad,
        "left_m": left_m,
        "right_m": right_m,
    })
}

fn expression(expression: &Expression) -> Value {
    let parameter = |(name, unit, value, sigma): &(String, String, f64, f64)| json!({"name": name, "unit": unit, "value": value, "sigma": sigma});
    json!({
        "equation": expression.equation,
        "parameters": expression.parameters.iter().map(parameter).collect::<Vec<_>>(),
        "position_rms_m": expression.position_rms_m,
    })
}

fn next_run(next: &NextRun) -> Value {
    json!({
        "kind": next.kind.name(),
        "separates": next.separates,
        "why": words::predicted(&next.predicted),
    })
}

#[cfg(test)]
mod tests {
    use robot_model::explain::{CandidateKind, PredictedSeparation, Reason};

    use super::*;
    use crate::empty_answer::{nothing_found, step_of};

    /// An answer with one of everything.
    fn found() -> Answer {
        let parameter = ParameterFound {
            name: "k".into(),
            unit: "s".into(),
            value: 0.02,
            sigma: 0.001,
            low95: 0.018,
            high95: 0.022,
        };
        Answer {
            steps: vec![StepFound { parameters: vec![parameter], ..step_of(&["side_slip"]) }],
            rejected: vec![Rejected {
                effect: "scrub".into(),
                reason: Reason::InModel,
                cross_validated: Errors::default(),
            }],
            next_run: Some(NextRun {
                kind: CandidateKind::Straight,
                separates: Vec::new(),
                predicted: PredictedSeparation::default(),
            }),
            ..nothing_found()
        }
    }

    #[test]
    fn the_json_has_the_keys_that_it_is_specified_to_have() {
        let json = answer(&found(), "One effect is missing.", &[]);
        let keys = |of: &Value| -> Vec<String> {
            let mut keys: Vec<String> = of.as_object().unwrap().keys().cloned().collect();
            keys.sort();
            keys
        };
        let top = [
            "baseline",
            "clocks",
            "data_hypotheses",
            "fitted_along",
            "floor",
            "next_run",
            "rejected",
            "schema",
            "steps",
            "tolerance_m",
            "unexplained",
            "verdict",
        ];
        assert_eq!(keys(&json), top);
        assert_eq!(json["schema"], 2);
        assert_eq!(keys(&json["baseline"]), ["heldout", "train"]);
        let error = ["chi", "heading_rms_rad", "position_rms_m"];
        assert_eq!(keys(&json["baseline"]["train"]), error);
        let step = [
            "class",
            "effect",
            "effect_size_m",
            "heldout",
            "matters",
            "p_value",
            "parameters",
            "train",
            "used_to_predict",
            "why",
        ];
        assert_eq!(keys(&json["steps"][0]), step);
        let parameter = ["high95", "low95", "name", "sigma", "unit", "value"];
        assert_eq!(keys(&json["steps"][0]["parameters"][0]), parameter);
        assert_eq!(keys(&json["rejected"][0]), ["effect", "heldout", "reason"]);
        assert_eq!(
            keys(&json["unexplained"]),
            ["depends_on", "expression", "p_value", "size_m", "structure"]
        );
        let runs_off = vec!["loaded".to_owned()];
        let off = unexplained(&Unexplained { runs_off, ..Unexplained::default() });
        assert_eq!(off["runs_off"], json!(["loaded"]));
        assert_eq!(keys(&json["next_run"]), ["kind", "separates", "why"]);
    }
}
