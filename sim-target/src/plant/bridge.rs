//! The motor driver.

use serde::{Deserialize, Serialize};

/// What differs between motor drivers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BridgeParameters {
    /// Disabled, the driver shorts the motors, so that they brake; otherwise their terminals are open.
    pub shorts_when_off: bool,
    /// From a new duty to its effect, in calls of [`Plant::set_duty`](super::Plant::set_duty): the robot makes one a
    /// millisecond.
    pub delay_ms: u8,
}
