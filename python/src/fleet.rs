//! Many robots: what their campaigns are fitted with, and what the values say.

use findings::json;
use pyo3::prelude::*;
use robot_model::fleet;
use robot_model::fleet::{Found, Measured};

/// The ids of the effects that all campaigns of a kind are fitted with. What each names: an effect, all that its runs cannot tell
/// from it, whether it matters.
#[pyfunction]
pub fn common_effects(found: Vec<(String, Vec<String>, bool)>) -> Vec<String> {
    let found = found.into_iter().map(|(effect, class, matters)| Found { effect, class, matters });
    let effects = fleet::common_effects(&found.collect::<Vec<_>>());
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
