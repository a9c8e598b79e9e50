//! The serial line between host and robot.

use serde::{Deserialize, Serialize};

use crate::plant::{ParameterError, RangeCheck};
use crate::wire::WireParameters;

/// The line's speed, lost frames and flipped bits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LinkParameters {
    /// Bits per second, ten to a byte; 0 for no delay at all.
    pub baud: u32,
    /// Share of the host's frames that are lost.
    pub frame_loss_to_robot: f64,
    /// Share of the robot's frames that are lost.
    pub frame_loss_to_host: f64,
    /// Share of bits that flip, either way.
    pub bit_error: f64,
}

impl Default for LinkParameters {
    /// A good USB serial adapter.
    fn default() -> Self {
        Self { baud: 921_600, frame_loss_to_robot: 0.0, frame_loss_to_host: 0.0, bit_error: 0.0 }
    }
}

impl LinkParameters {
    /// Refuses a value outside its range, and names the field.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let check = RangeCheck("");
        if self.baud != 0 {
            check.within("baud", self.baud.into(), 1200.0, 1e8)?;
        }
        check.within("frame_loss_to_robot", self.frame_loss_to_robot, 0.0, 1.0)?;
        check.within("frame_loss_to_host", self.frame_loss_to_host, 0.0, 1.0)?;
        check.within("bit_error", self.bit_error, 0.0, 1.0)
    }

    /// The direction from host to robot.
    pub(super) fn to_robot(self) -> WireParameters {
        self.wire(self.frame_loss_to_robot)
    }

    /// The direction from robot to host.
    pub(super) fn to_host(self) -> WireParameters {
        self.wire(self.frame_loss_to_host)
    }

    fn wire(self, frame_loss: f64) -> WireParameters {
        WireParameters { baud: self.baud, frame_loss, bit_error: self.bit_error }
    }
}
