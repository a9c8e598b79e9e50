//! A model whose effects the user chose, fitted.

use robot_model::explain::HeldOut;
use robot_model::explain::model::{Model, ModelEffect};
use serde_json::{Value, json};

use super::answer::{errors, pair, parameters};
use crate::words;

/// A fitted model.
pub fn fitted(model: &Model) -> Value {
    json!({
        "schema": 1,
        "nominal": pair(&model.nominal),
        "errors": pair(&model.errors),
        "aside": held_out(model.held_out.as_ref()),
        "effects": effects(model),
    })
}

/// Its effects, each with its verdict.
pub fn effects(model: &Model) -> Value {
    let effect = |effect: &ModelEffect| {
        json!({
            "effect": effect.effect,
            "parameters": parameters(&effect.parameters),
            "p_value": effect.verdict.p_value,
            "better": effect.verdict.better(),
            "verdict": words::verdict(&effect.verdict),
        })
    };
    model.effects.iter().map(effect).collect()
}

/// Its errors on the held-out runs; null if there are none.
pub fn held_out(held_out: Option<&HeldOut>) -> Value {
    held_out.map_or(Value::Null, |held_out| {
        let kinds: Vec<_> = held_out.kinds.iter().map(|kind| kind.name()).collect();
        json!({"runs": held_out.runs, "kinds": kinds, "errors": errors(&held_out.model)})
    })
}
