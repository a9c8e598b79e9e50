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
    /// How sure that is.
    pub deviation: PoseDeviation,
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

/// How sure a [`Pose`] is: standard deviations of its numbers, and their correlations.
///
/// Of what the wheels' travel scatters by, and of what W_T and the track width are known to ([`OdometryConfig`]). All are 0 at
/// power-on.
///
/// [`OdometryConfig`]: crate::OdometryConfig
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PoseDeviation {
    /// Of x \[um\].
    pub x_um: u32,
    /// Of y \[um\].
    pub y_um: u32,
    /// Of the heading \[urad\].
    pub heading_urad: u32,
    /// Correlation of x and y \[1/8191\]: fine enough, and two bytes on the wire.
    pub x_y: i16,
    /// Of x and heading \[1/8191\].
    pub x_heading: i16,
    /// Of y and heading \[1/8191\].
    pub y_heading: i16,
}

impl PoseDeviation {
    /// The covariance matrix of x \[m\], y \[m\] and heading \[rad\], row by row: symmetric, and of what a robot sends
    /// positive semidefinite.
    ///
    /// In `pose.covariance` of ROS's `nav_msgs/Odometry`, which has six rows of six, these are the rows and columns 0, 1 and 5.
    pub fn covariance(&self) -> [f64; 9] {
        let [x, y, heading] =
            [self.x_um, self.y_um, self.heading_urad].map(|sd| f64::from(sd) * 1e-6);
        let share = |correlation: i16| f64::from(correlation) / 8191.0;
        let x_y = share(self.x_y) * x * y;
        let x_heading = share(self.x_heading) * x * heading;
        let y_heading = share(self.y_heading) * y * heading;
        [x * x, x_y, x_heading, x_y, y * y, y_heading, x_heading, y_heading, heading * heading]
    }
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

#[cfg(test)]
mod tests {
    use super::PoseDeviation;

    #[test]
    fn deviations_and_correlations_make_a_symmetric_matrix_in_metres_and_radians() {
        let deviation = PoseDeviation {
            x_um: 2_000_000,
            y_um: 500_000,
            heading_urad: 100_000,
            x_y: 8191,
            x_heading: -8191,
            y_heading: 0,
        };
        let expected = [4.0, 1.0, -0.2, 1.0, 0.25, 0.0, -0.2, 0.0, 0.01];
        for (found, expected) in deviation.covariance().into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        assert_eq!(PoseDeviation::default().covariance(), [0.0; 9]);
    }
}
