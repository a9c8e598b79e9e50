//! Many robots: what their campaigns are fitted with, and what the values say.

use std::sync::Arc;

use findings::json;
use pyo3::prelude::*;
use robot_model::effect::{CATALOGUE, CustomEffect, Effect};
use robot_model::fleet;
use robot_model::fleet::{Found, Measured};

use crate::model::Model;

/// The ids of the effects that all campaigns of a kind are fitted with. What each names: an effect, all that its runs cannot tell
/// from it, whether it matters. Besides the catalogue, only equations that all of the models declare alike can be fitted to all.
#[pyfunction]
pub fn common_effects(
    found: Vec<(String, Vec<String>, bool)>,
    models: Vec<Py<Model>>,
) -> Vec<String> {
    let found = found.into_iter().map(|(effect, class, matters)| Found { effect, class, matters });
    let mut candidates: Vec<&dyn Effect> = CATALOGUE.to_vec();
    if let Some((first, others)) = models.split_first() {
        let are_declared = |own: &&Arc<CustomEffect>| {
            let declares = |model: &Py<Model>| {
                model.get().file.customs.iter().any(|other| other.custom() == own.custom())
            };
            others.iter().all(declares)
        };
        let own = first.get().file.customs.iter().filter(are_declared);
        candidates.extend(own.map(|own| own.as_ref() as &dyn Effect));
    }
    let effects = fleet::common_effects(&found.collect::<Vec<_>>(), &candidates);
    effects.iter().map(|effect| effect.facts().id.to_owned()).collect()
}

/// Number of the robot, day, value, standard error.
type Value = (usize, Option<f64>, f64, f64);

/// Judges parameters, each with its values. JSON.
#[pyfunction]
pub fn judge(parameters: Vec<Vec<Value>>) -> String {
    let sound =
        |(_, _, value, sigma): &Value| value.is_finite() && sigma.is_finite() && *sigma > 0.0;
    let measured = |(robot, at_days, value, sigma)| Measured { robot, at_days, value, sigma };
    let parameters: Vec<Vec<Measured>> = parameters
        .into_iter()
        .map(|values| values.into_iter().filter(sound).map(measured).collect())
        .collect();
    let judged = fleet::judge(&parameters);
    let each = judged.iter().map(|one| json::judgement(one, |robot| robot.into()));
    serde_json::Value::from_iter(each).to_string()
}
