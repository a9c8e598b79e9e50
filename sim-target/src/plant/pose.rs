//! The robot's pose and motion.

use serde::{Deserialize, Serialize};

use super::rotation::Rotation;

/// Position of the driven wheels' axle midpoint, and heading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pose {
    /// Along the start line, unless another frame is given \[m\].
    pub x_m: f64,
    /// To the left of the start line \[m\].
    pub y_m: f64,
    /// Counter-clockwise from the start line, not wrapped \[rad\].
    pub heading_rad: f64,
}

impl Pose {
    /// This pose in the frame of `line`.
    pub fn relative_to(self, line: Pose) -> Pose {
        let (x_m, y_m) = (self.x_m - line.x_m, self.y_m - line.y_m);
        let (x_m, y_m) = Rotation::new(line.heading_rad).undo(x_m, y_m);
        Pose { x_m, y_m, heading_rad: self.heading_rad - line.heading_rad }
    }

    /// The pose that has the coordinates `seen` in this pose's frame: the inverse of
    /// [`relative_to`](Self::relative_to).
    pub fn then(self, seen: Pose) -> Pose {
        let (x_m, y_m) = Rotation::new(self.heading_rad).apply(seen.x_m, seen.y_m);
        Pose {
            x_m: self.x_m + x_m,
            y_m: self.y_m + y_m,
            heading_rad: self.heading_rad + seen.heading_rad,
        }
    }
}

/// Motion of the axle's midpoint, in the robot's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Forward speed \[m/s\].
    pub forward_mps: f64,
    /// Speed to the left \[m/s\]: what the tyres slip sideways.
    pub left_mps: f64,
    /// Yaw rate, counter-clockwise positive \[rad/s\].
    pub yaw_rate_rad_s: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_seen_from_a_line_and_put_back_is_the_same_pose() {
        let line = Pose { x_m: 0.3, y_m: -2.0, heading_rad: 2.1 };
        let pose = Pose { x_m: -1.0, y_m: 0.7, heading_rad: 9.0 };
        let back = line.then(pose.relative_to(line));
        assert!((back.x_m - pose.x_m).abs() < 1e-14);
        assert!((back.y_m - pose.y_m).abs() < 1e-14);
        assert_eq!(back.heading_rad, pose.heading_rad);
    }

    #[test]
    fn left_of_a_line_that_points_left_is_backwards() {
        let line = Pose { heading_rad: core::f64::consts::FRAC_PI_2, ..Pose::default() };
        let seen = Pose { x_m: -0.4, ..Pose::default() }.relative_to(line);
        assert!((seen.y_m - 0.4).abs() < 1e-15 && seen.x_m.abs() < 1e-15);
    }
}
