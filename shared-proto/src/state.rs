//! The robot's state.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// The robot's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Reading its configuration.
    Boot,
    /// Motors off.
    Idle,
    /// Motors on, standing still.
    Armed,
    /// A motion is under way.
    Driving,
    /// Braking along a ramp.
    Stopping,
    /// Motors off because of a latched fault.
    Faulted,
}

impl State {
    /// `"idle"`.
    pub const fn name(self) -> &'static str {
        match self {
            State::Boot => "boot",
            State::Idle => "idle",
            State::Armed => "armed",
            State::Driving => "driving",
            State::Stopping => "stopping",
            State::Faulted => "faulted",
        }
    }
}
