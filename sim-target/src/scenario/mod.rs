//! A scenario: one simulated robot, its surroundings and its faults, as TOML data.
//!
//! ```toml
//! name = "unequal motors"
//! seed = 7                       # draws everything that is random
//!
//! [plant]                        # overrides of the standard robot, crate::plant::PlantParameters
//! geometry.wheel_radius_m = { left = 0.036, right = 0.0357 }
//! motor.left.coulomb_torque_nm = 0.07
//!
//! [placement]                    # how the robot is put on the start line
//! heading_sigma_rad = 0.002
//!
//! [camera]                       # crate::instruments::CameraParameters
//! [ruler]                        # crate::instruments::RulerParameters
//! [gyro]                         # crate::instruments::GyroParameters; without this table there is none
//! [link]                         # the serial line
//!
//! [[fault]]
//! kind = "encoder_unplugged"     # a crate::plant::PlantFault
//! wheel = "left"
//! at_s = 8.0                     # simulated time; or at_motion_s, from the first time the motors are driven
//! until_s = 9.0                  # optional, on the same clock
//! ```
//!
//! A field that is left out keeps its type's default. What the robot assumes about itself is its
//! configuration, not part of a scenario.

mod error;
mod fault;
mod hidden;
mod link;
mod random_robot;
mod setup;
mod start_pose;

use std::path::Path;

use serde::{Deserialize, Serialize};

pub use error::ScenarioError;
pub use fault::{FaultClock, ScheduledFault};
pub use hidden::{HiddenEffect, ShownBy};
pub use link::LinkParameters;
pub use setup::{FaultEvent, Setup};
pub use start_pose::PlacementParameters;

use crate::instruments::{CameraParameters, GyroParameters, RulerParameters};
use crate::plant::{ParameterError, PlantParameters};

/// One simulated robot and its surroundings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// The scenario's name.
    pub name: String,
    /// Draws everything that is random.
    #[serde(default)]
    pub seed: u64,
    /// The robot and its floor, as they truly are.
    #[serde(default)]
    pub plant: PlantParameters,
    /// How the robot is put on the start line.
    #[serde(default)]
    pub placement: PlacementParameters,
    /// The overhead camera.
    #[serde(default)]
    pub camera: CameraParameters,
    /// The ruler.
    #[serde(default)]
    pub ruler: RulerParameters,
    /// The gyro, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gyro: Option<GyroParameters>,
    /// The serial line.
    #[serde(default)]
    pub link: LinkParameters,
    /// Faults and their times.
    #[serde(default, rename = "fault", skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<ScheduledFault>,
}

impl Default for Scenario {
    /// The paper's robot: the right wheel 0.9919 of the left one, as `scenarios/paper.toml` has it.
    fn default() -> Self {
        Self::parse("paper.toml", include_str!("../../scenarios/paper.toml"))
            .unwrap_or_else(|error| panic!("the built-in scenario is broken: {error}"))
    }
}

impl Scenario {
    /// Reads a file.
    pub fn load(path: &Path) -> Result<Self, ScenarioError> {
        let origin = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&origin, &text),
            Err(error) => Err(ScenarioError::unreadable(&origin, &error)),
        }
    }

    /// Reads TOML text; errors name `origin`.
    pub fn parse(origin: &str, text: &str) -> Result<Self, ScenarioError> {
        let scenario: Self =
            toml::from_str(text).map_err(|error| ScenarioError::syntax(origin, text, &error))?;
        scenario.validate().map_err(|error| ScenarioError::value(origin, text, &error))?;
        Ok(scenario)
    }

    /// The scenario as TOML text, which [`parse`](Self::parse) reads back.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a scenario holds nothing that TOML cannot")
    }

    /// Refuses a value outside its range, and names the field.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let within = |section: &str, result: Result<(), ParameterError>| {
            result.map_err(|error| ParameterError {
                field: format!("{section}.{}", error.field),
                ..error
            })
        };
        within("plant", self.plant.validate())?;
        within("placement", self.placement.validate())?;
        within("camera", self.camera.validate())?;
        within("ruler", self.ruler.validate())?;
        if let Some(gyro) = &self.gyro {
            within("gyro", gyro.validate())?;
        }
        within("link", self.link.validate())?;
        self.faults.iter().try_for_each(|fault| within("fault", fault.validate()))
    }
}

#[cfg(test)]
mod tests;
