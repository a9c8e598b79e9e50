//! Which simulated robot a campaign was recorded on.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The simulated robot. The port of a real robot is not kept, as it depends on the computer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Simulated {
    /// The name of the scenario's file, without its folders; none for the built-in scenario.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scenario: Option<String>,
    /// The seed that replaced the scenario's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
}

impl fmt::Display for Simulated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let scenario = self.scenario.as_deref().unwrap_or("the built-in one");
        match self.seed {
            Some(seed) => write!(f, "{scenario}, seed {seed}"),
            None => write!(f, "{scenario}"),
        }
    }
}
