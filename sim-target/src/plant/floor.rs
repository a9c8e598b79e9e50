//! What the robot stands on.

use serde::{Deserialize, Serialize};

use super::parameters::{Check, ParameterError};

/// The floor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FloorParameters {
    /// Acceleration of gravity, g \[m/s^2\].
    pub gravity_mps2: f64,
    /// Grip of every wheel, mu: the largest contact force as a share of the load.
    pub friction: f64,
}

impl Default for FloorParameters {
    /// Rubber on a smooth hard floor.
    fn default() -> Self {
        Self { gravity_mps2: 9.81, friction: 0.7 }
    }
}

impl FloorParameters {
    pub(super) fn check(&self, check: &Check) -> Result<(), ParameterError> {
        check.within("gravity_mps2", self.gravity_mps2, 0.1, 30.0)?;
        check.within("friction", self.friction, 0.0, 3.0)
    }
}
