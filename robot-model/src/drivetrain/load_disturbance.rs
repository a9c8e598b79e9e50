//! Does something push the robot: a slope, a cable?
//!
//! Friction against the motion is a property of the motors, and goes with the robot. A push along its way is one of the
//! floor, and does not. Both show as kS by direction. The motors of the two sides are mounted mirrored, so what their
//! brushes and gears prefer is forwards for one wheel and backwards for the other; a push is the same for both.
//!
//! ```text
//! a = (kS- - kS+) / 2      by wheel; a push forwards is positive                                        (1)
//! ```

use super::fit::{Constants, HalfWidths};
use super::model::WheelMotor;
use crate::kinematics::WheelPair;

/// Both wheels' (1) are alike if they differ by less than this share of their mean.
const ALIKE: f64 = 0.5;
/// Beyond this share of the friction a robot is about to roll by itself.
const HELD: f64 = 0.8;

/// A push that both wheels feel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadDisturbance {
    /// In volts at each motor, forwards positive.
    pub volts: f64,
    /// Friction holds the robot against it.
    pub held: bool,
}

impl Constants {
    /// The push on the robot, if both wheels show it beyond their intervals.
    pub fn load_disturbance(&self) -> Option<LoadDisturbance> {
        let asymmetry = |motor: &WheelMotor| 0.5 * (motor.ks_backward_v - motor.ks_forward_v);
        let half_width = |off: &HalfWidths| 0.5 * off.ks_backward_v.hypot(off.ks_forward_v);
        let WheelPair { left, right } = self.value.wheels;
        let (a, b) = (asymmetry(&left), asymmetry(&right));
        let volts = 0.5 * (a + b);
        let shows = a.abs() > half_width(&self.half_widths_95.left)
            && b.abs() > half_width(&self.half_widths_95.right);
        let friction_v = 0.5 * (left.ks_mean_v() + right.ks_mean_v());
        (shows && (a - b).abs() < ALIKE * volts.abs())
            .then_some(LoadDisturbance { volts, held: volts.abs() < HELD * friction_v })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drivetrain::Drivetrain;

    /// kS+ and kS- of the left and the right wheel, each known to 0.05 V.
    fn constants(ks_v: [f64; 4]) -> Constants {
        let motor = |forward: f64, backward: f64| WheelMotor {
            ks_forward_v: forward,
            ks_backward_v: backward,
            kv_v_s_per_m: 24.0,
            ka_v_s2_per_m: 0.7,
        };
        let wheels = WheelPair::new(motor(ks_v[0], ks_v[1]), motor(ks_v[2], ks_v[3]));
        let off = HalfWidths { ks_forward_v: 0.05, ks_backward_v: 0.05, ..HalfWidths::default() };
        Constants {
            value: Drivetrain { wheels, ..Drivetrain::default() },
            half_widths_95: WheelPair::both(off),
        }
    }

    #[test]
    fn a_slope_pushes_both_wheels_alike_and_a_motors_liking_does_not() {
        let push = constants([0.35, 0.65, 0.30, 0.62]).load_disturbance().unwrap();
        assert!((push.volts - 0.155).abs() < 1e-12 && push.held, "{push:?}");
        assert!(constants([0.65, 0.35, 0.62, 0.30]).load_disturbance().unwrap().volts < 0.0);
        // Mirrored motors; one wheel alone; within the intervals.
        for ks_v in [[0.35, 0.65, 0.62, 0.30], [0.35, 0.65, 0.45, 0.45], [0.48, 0.52, 0.44, 0.47]] {
            assert_eq!(constants(ks_v).load_disturbance(), None, "{ks_v:?}");
        }
    }

    #[test]
    fn a_robot_that_is_about_to_roll_by_itself_is_not_held() {
        assert!(!constants([0.0, 1.4, 0.0, 1.3]).load_disturbance().unwrap().held);
        assert!(!constants([1.3, 0.1, 1.3, 0.1]).load_disturbance().unwrap().held);
    }
}
