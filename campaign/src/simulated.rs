//! Which simulated robot a campaign is of.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Which simulated robot it was. Where a real one is reached is a matter of the machine, and not kept.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Simulated {
    /// The scenario's file as the user wrote it, without the folders of one machine; none for the built-in one.
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
