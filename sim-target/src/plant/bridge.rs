//! The motor driver.

use serde::{Deserialize, Serialize};

/// What differs between motor drivers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BridgeParameters {
    /// Disabled, the driver shorts the motors, so that they brake; otherwise their terminals are open.
    pub shorts_when_off: bool,
}
