//! Telemetry: the robot at one control tick.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::pair::WheelPair;
use crate::state::State;

/// The robot's state and both wheels at one control tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Telemetry {
    /// Rises by one from frame to frame while the period stays the same, and wraps. A frame that is missing
    /// can be recalled by [`Command::Recall`](crate::Command::Recall).
    pub number: u32,
    /// Time of the control tick since power-on \[us\].
    pub t_us: u64,
    /// The robot's state.
    pub state: State,
    /// The encoder-sign check is under way; the loop is open.
    pub probing: bool,
    /// Each wheel's values.
    pub wheels: WheelPair<WheelTelemetry>,
    /// Supply \[mV\].
    pub supply_mv: u16,
    /// Where the robot is, by dead reckoning.
    pub pose: Pose,
}

/// Where the robot is by its own counts: the middle between its wheels, since power-on.
///
/// x points ahead and y to the left of the robot at power-on; the heading is to the left positive, and not wrapped. With
/// W_T, track width and heading pull as configured. What no encoder sees, slip for one, is not in it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Pose {
    /// Ahead \[um\].
    pub x_um: i64,
    /// To the left \[um\].
    pub y_um: i64,
    /// \[urad\]
    pub heading_urad: i64,
}

impl Telemetry {
    /// The robot keeps this many frames for [`Command::Recall`](crate::Command::Recall): a third of a second at 100 Hz.
    pub const KEPT: u32 = 32;
}

/// One wheel at one control tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct WheelTelemetry {
    /// Absolute encoder count, forward positive.
    pub counts: i64,
    /// Where the wheel should be \[um of travel\].
    pub setpoint_um: i64,
    /// Setpoint minus measured travel \[um\].
    pub error_um: i32,
    /// Measured speed \[um/s\].
    pub speed_um_s: i32,
    /// Feedforward, proportional, integral and derivative parts of the duty \[1/32767\].
    pub terms: PidTerms,
    /// Duty as applied to the motor, forward positive \[1/32767\].
    pub duty: i16,
    /// The motor's voltage, duty times supply, summed over time since power-on, up to the instant of the counts \[uV s\]: this
    /// tick's duty begins then. The mean voltage between two frames is the difference over their time, whatever frames between
    /// them were lost.
    pub applied_uvs: i64,
}

/// The parts that make up a duty \[1/32767\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct PidTerms {
    /// From the profile alone.
    pub feedforward: i16,
    /// From the travel error.
    pub proportional: i16,
    /// From the travel error's sum.
    pub integral: i16,
    /// From the speed error.
    pub derivative: i16,
}
