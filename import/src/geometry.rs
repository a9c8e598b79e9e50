//! The numbers by which a program computes odometry, and the way back: from odometry to the wheels.
//!
//! ```text
//! v = (r_l w_l + r_r w_r) / 2,   omega = (r_r w_r - r_l w_l) / b                     (1)
//! r_l = wheel_radius * left_wheel_radius_multiplier, r_r likewise, b = wheel_separation * wheel_separation_multiplier
//! w_l = (v - omega b / 2) / r_l,   w_r = (v + omega b / 2) / r_r                     (2)
//! ```
//!
//! The names are those of ROS 2's `diff_drive_controller`. (2) inverts (1) exactly: nothing is lost in it but digits.

/// Radii and track width of a controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// Nominal radius of both wheels \[m\].
    pub wheel_radius_m: f64,
    /// What makes the left and the right radius of it.
    pub radius_multipliers: [f64; 2],
    /// Nominal track width \[m\].
    pub wheel_separation_m: f64,
    /// What makes the effective one of it.
    pub separation_multiplier: f64,
}

impl Geometry {
    /// Wheels of one radius, this far apart \[m\].
    pub fn nominal(wheel_radius_m: f64, wheel_separation_m: f64) -> Self {
        Self {
            wheel_radius_m,
            radius_multipliers: [1.0; 2],
            wheel_separation_m,
            separation_multiplier: 1.0,
        }
    }

    /// Radius of the left and of the right wheel \[m\].
    pub fn radii_m(&self) -> [f64; 2] {
        self.radius_multipliers.map(|multiplier| self.wheel_radius_m * multiplier)
    }

    /// The effective track width \[m\].
    pub fn track_width_m(&self) -> f64 {
        self.wheel_separation_m * self.separation_multiplier
    }

    /// By how much the left and the right wheel turn while the robot goes so far and turns so far; equation (2) \[m, rad\].
    pub fn wheels_turned_rad(&self, travel_m: f64, turn_rad: f64) -> [f64; 2] {
        let [left_m, right_m] = self.radii_m();
        let half_m = turn_rad * self.track_width_m() / 2.0;
        [(travel_m - half_m) / left_m, (travel_m + half_m) / right_m]
    }
}
