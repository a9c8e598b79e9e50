//! What distorts the camera's measurement: the marker's place on the robot, and the lens.

use serde::{Deserialize, Serialize};

use crate::plant::{ParameterError, Pose, RangeCheck};

/// Where the marker is on the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MarkerParameters {
    /// In front of the axle's midpoint \[m\].
    pub forward_m: f64,
    /// To the left of the axle's midpoint \[m\].
    pub left_m: f64,
}

/// The lens's radial distortion.
///
/// ```text
/// seen = c + (p - c)(1 + k |p - c|^2)             (1)
/// ```
///
/// with p on the floor and c under the camera: the first radial term of the Brown-Conrady model, as
/// lengths on the floor. k below zero is a barrel, above it a pincushion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LensParameters {
    /// Radial distortion, k \[1/m^2\].
    pub distortion_per_m2: f64,
    /// Under the camera, along the x axis \[m\].
    pub center_x_m: f64,
    /// Under the camera, along the y axis \[m\].
    pub center_y_m: f64,
}

impl MarkerParameters {
    pub(super) fn validate(&self) -> Result<(), ParameterError> {
        let check = RangeCheck("marker.");
        check.within("forward_m", self.forward_m, -2.0, 2.0)?;
        check.within("left_m", self.left_m, -2.0, 2.0)
    }

    /// The marker's pose on a robot that stands there.
    pub(super) fn seen_on(&self, robot: Pose) -> Pose {
        robot.then(Pose { x_m: self.forward_m, y_m: self.left_m, heading_rad: 0.0 })
    }
}

impl LensParameters {
    pub(super) fn validate(&self) -> Result<(), ParameterError> {
        let check = RangeCheck("lens.");
        check.within("distortion_per_m2", self.distortion_per_m2, -0.1, 0.1)?;
        check.within("center_x_m", self.center_x_m, -100.0, 100.0)?;
        check.within("center_y_m", self.center_y_m, -100.0, 100.0)
    }

    /// The measured pose of a marker (1). Its heading is the direction of an edge in the picture.
    pub(super) fn bend(&self, pose: Pose) -> Pose {
        let k = self.distortion_per_m2;
        if k == 0.0 {
            return pose;
        }
        let (x, y) = (pose.x_m - self.center_x_m, pose.y_m - self.center_y_m);
        let square = x * x + y * y;
        let stretch = 1.0 + k * square;
        // An edge along (cos, sin) is pictured along J (cos, sin), J being the derivative of (1).
        let (sin, cos) = pose.heading_rad.sin_cos();
        let along = 2.0 * k * (x * cos + y * sin);
        let (ex, ey) = (stretch * cos + along * x, stretch * sin + along * y);
        let turned_rad = (cos * ey - sin * ex).atan2(cos * ex + sin * ey);
        Pose {
            x_m: self.center_x_m + x * stretch,
            y_m: self.center_y_m + y * stretch,
            heading_rad: pose.heading_rad + turned_rad,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_marker_off_the_axle_moves_when_the_robot_turns_on_the_spot() {
        let marker = MarkerParameters { forward_m: 0.03, left_m: 0.01 };
        let quarter = Pose { heading_rad: core::f64::consts::FRAC_PI_2, ..Pose::default() };
        let seen = marker.seen_on(quarter);
        assert!((seen.x_m + 0.01).abs() < 1e-15 && (seen.y_m - 0.03).abs() < 1e-15, "{seen:?}");
    }

    #[test]
    fn a_barrel_pulls_far_points_inwards_and_turns_what_is_not_radial_as_its_derivative_says() {
        let lens = LensParameters { distortion_per_m2: -0.01, ..LensParameters::default() };
        let pose = Pose { x_m: 2.0, y_m: 1.0, heading_rad: 0.4 };
        let seen = lens.bend(pose);
        assert!((seen.x_m - 2.0 * 0.95).abs() < 1e-12 && (seen.y_m - 0.95).abs() < 1e-12);
        let step = 1e-6;
        let ahead = lens.bend(pose.then(Pose { x_m: step, ..Pose::default() }));
        let direction_rad = (ahead.y_m - seen.y_m).atan2(ahead.x_m - seen.x_m);
        // A finite difference over a micrometre, of a curve with a radius of metres.
        assert!((seen.heading_rad - direction_rad).abs() < 1e-6, "{seen:?} {direction_rad}");
        assert!((seen.heading_rad - 0.4).abs() > 1e-3, "and its heading changes");
    }

    #[test]
    fn a_true_lens_and_a_centred_marker_change_no_bit() {
        let pose = Pose { x_m: 2.1, y_m: -1.3, heading_rad: 7.4 };
        assert_eq!(LensParameters::default().bend(pose), pose);
        assert_eq!(MarkerParameters::default().seen_on(pose), pose);
    }
}
