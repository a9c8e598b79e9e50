//! What the page asks for: the effects of a model, fitted or at values set by hand.

use std::collections::BTreeSet;

use campaign::model::ModelFile;
use robot_model::effect::KnownEffect;
use serde::Deserialize;

/// More effects than the catalogue has are no question of the page's.
const EFFECTS_MAX: usize = 40;

/// A model: its effects.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelRequest {
    /// In their order.
    pub effects: Vec<EffectRequest>,
    /// What takes long is left out, unless it is known already.
    #[serde(default)]
    pub quick: bool,
}

/// One effect.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectRequest {
    /// Its id.
    pub id: String,
    /// Its parameters' values if they are set by hand; otherwise they are fitted. All effects or none.
    #[serde(default)]
    pub values: Option<Vec<f64>>,
}

impl ModelRequest {
    /// These effects, fitted.
    pub fn fitted(ids: &[&str]) -> Self {
        let effect = |id: &&str| EffectRequest { id: (*id).to_owned(), values: None };
        Self { effects: ids.iter().map(effect).collect(), quick: false }
    }

    /// The effects themselves; the error says what is wrong with the request.
    pub fn known(&self, model: &ModelFile) -> Result<Vec<KnownEffect>, String> {
        if self.effects.len() > EFFECTS_MAX {
            return Err(format!("at most {EFFECTS_MAX} effects"));
        }
        let mut seen = BTreeSet::new();
        if let Some(twice) = self.effects.iter().find(|effect| !seen.insert(&effect.id)) {
            return Err(format!("{} stands there twice", twice.id));
        }
        let by_hand = self.effects.iter().filter(|effect| effect.values.is_some()).count();
        if by_hand != 0 && by_hand != self.effects.len() {
            return Err("give values for all effects, or for none".to_owned());
        }
        self.effects.iter().map(|effect| effect.known(model)).collect()
    }

    /// The values set by hand, effect by effect; `None` if they are to be fitted.
    pub fn values(&self) -> Option<Vec<&[f64]>> {
        if self.effects.is_empty() {
            return None;
        }
        self.effects.iter().map(|effect| effect.values.as_deref()).collect()
    }

    /// What tells this request from others.
    pub fn key(&self) -> String {
        let effect = |effect: &EffectRequest| match &effect.values {
            None => effect.id.clone(),
            Some(values) => format!("{}{values:?}", effect.id),
        };
        self.effects.iter().map(effect).collect::<Vec<_>>().join(",")
    }
}

impl EffectRequest {
    fn known(&self, model: &ModelFile) -> Result<KnownEffect, String> {
        let known =
            model.find(&self.id).ok_or_else(|| format!("there is no effect `{}`", self.id))?;
        let Some(values) = &self.values else { return Ok(known) };
        let facts = known.facts();
        if values.len() != facts.parameters.len() {
            let count = facts.parameters.len();
            return Err(format!("{} has {count} parameters, not {}", self.id, values.len()));
        }
        for (value, parameter) in values.iter().zip(facts.parameters) {
            let (low, high) = parameter.possible;
            if !value.is_finite() || *value <= low || *value >= high {
                return Err(format!("{}: {} cannot be {value}", self.id, parameter.name));
            }
        }
        Ok(known)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(json: &str) -> String {
        let request: ModelRequest = serde_json::from_str(json).unwrap();
        request.known(&ModelFile::default()).unwrap_err()
    }

    #[test]
    fn a_request_that_makes_no_sense_is_told_why() {
        for (json, expected) in [
            (r#"{"effects":[{"id":"no_such"}]}"#, "no effect `no_such`"),
            (r#"{"effects":[{"id":"scrub"},{"id":"scrub"}]}"#, "twice"),
            (
                r#"{"effects":[{"id":"scrub","values":[0.01]},{"id":"side_slip"}]}"#,
                "for all effects",
            ),
            (
                r#"{"effects":[{"id":"speed_growth","values":[1.0,2.0]}]}"#,
                "has 1 parameters, not 2",
            ),
            (r#"{"effects":[{"id":"speed_growth","values":[-1.0]}]}"#, "cannot be -1"),
        ] {
            let problem = problem(json);
            assert!(problem.contains(expected), "{json}: {problem}");
        }
        for json in [r#"{"effects":[{"id":"scrub","extra":1}]}"#, r#"{"effects":7}"#, "[]"] {
            assert!(serde_json::from_str::<ModelRequest>(json).is_err(), "{json}");
        }
    }

    #[test]
    fn requests_with_other_values_or_effects_have_other_keys() {
        let key = |json: &str| serde_json::from_str::<ModelRequest>(json).unwrap().key();
        let fitted = key(r#"{"effects":[{"id":"scrub"}]}"#);
        assert_eq!(fitted, ModelRequest::fitted(&["scrub"]).key());
        let by_hand = key(r#"{"effects":[{"id":"scrub","values":[0.25]}]}"#);
        assert_ne!(fitted, by_hand);
        assert_ne!(by_hand, key(r#"{"effects":[{"id":"scrub","values":[0.250001]}]}"#));
    }
}
