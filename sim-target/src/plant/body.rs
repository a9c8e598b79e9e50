//! The robot's body: one rigid mass in the plane.

use serde::{Deserialize, Serialize};

use super::pose::{Pose, Twist};
use super::range_check::{ParameterError, RangeCheck};
use super::rotation::Rotation;

/// The body, wheels and load included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BodyParameters {
    /// Mass of the whole robot, m \[kg\].
    pub mass_kg: f64,
    /// Yaw inertia of the whole robot about its centre of mass, I \[kg m^2\].
    pub yaw_inertia_kgm2: f64,
    /// Centre of mass in front of the axle, c_x \[m\]; negative towards the caster.
    pub center_of_mass_forward_m: f64,
    /// Centre of mass to the left of the midline, c_y \[m\].
    pub center_of_mass_left_m: f64,
    /// Centre of mass above the floor, h \[m\].
    pub center_of_mass_height_m: f64,
    /// Payload at the centre of mass; adds no yaw inertia \[kg\].
    pub payload_kg: f64,
}

impl Default for BodyParameters {
    fn default() -> Self {
        Self {
            mass_kg: 4.0,
            yaw_inertia_kgm2: 0.07,
            center_of_mass_forward_m: -0.05,
            center_of_mass_left_m: 0.0,
            center_of_mass_height_m: 0.06,
            payload_kg: 0.0,
        }
    }
}

impl BodyParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        check.within("mass_kg", self.mass_kg, 0.05, 500.0)?;
        check.within("yaw_inertia_kgm2", self.yaw_inertia_kgm2, 1e-5, 500.0)?;
        check.within("center_of_mass_forward_m", self.center_of_mass_forward_m, -5.0, 0.0)?;
        check.within("center_of_mass_left_m", self.center_of_mass_left_m, -2.5, 2.5)?;
        check.within("center_of_mass_height_m", self.center_of_mass_height_m, 0.0, 2.0)?;
        check.within("payload_kg", self.payload_kg, 0.0, 500.0)
    }

    /// Mass including the payload \[kg\].
    pub(super) fn laden_mass_kg(&self) -> f64 {
        self.mass_kg + self.payload_kg
    }
}

/// Force and moment about the centre of mass, in the body's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Wrench {
    /// Forward force \[N\].
    pub forward_n: f64,
    /// Force to the left \[N\].
    pub left_n: f64,
    /// Yaw moment, counter-clockwise positive \[N m\].
    pub yaw_nm: f64,
}

/// The body's position and momentum.
///
/// The state is that of the centre of mass G: its place in the fixed frame, its velocity (u, v) in the
/// body's axes. All other modules use the axle's midpoint M, which lies at -c from G:
///
/// ```text
/// x_M = x_G - Rot(theta) c,   u_M = u + omega c_y,   v_M = v - omega c_x
/// ```
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    mass_inverse: f64,
    inertia_inverse: f64,
    pub center_x_m: f64,
    pub center_y_m: f64,
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
    rotation: Rotation,
    u_mps: f64,
    v_mps: f64,
    pub yaw_rate_rad_s: f64,
    /// Acceleration of the centre of mass in the last step, in the body's axes \[m/s^2\].
    pub acceleration_mps2: (f64, f64),
}

impl Body {
    pub fn new(parameters: &BodyParameters, start: Pose) -> Self {
        let rotation = Rotation::new(start.heading_rad);
        let (center_x_m, center_y_m) =
            (parameters.center_of_mass_forward_m, parameters.center_of_mass_left_m);
        let (offset_x, offset_y) = rotation.apply(center_x_m, center_y_m);
        Self {
            mass_inverse: 1.0 / parameters.laden_mass_kg(),
            inertia_inverse: 1.0 / parameters.yaw_inertia_kgm2,
            center_x_m,
            center_y_m,
            x_m: start.x_m + offset_x,
            y_m: start.y_m + offset_y,
            heading_rad: start.heading_rad,
            rotation,
            u_mps: 0.0,
            v_mps: 0.0,
            yaw_rate_rad_s: 0.0,
            acceleration_mps2: (0.0, 0.0),
        }
    }

    /// Adopts a new mass; the velocity does not change.
    pub fn set_mass(&mut self, parameters: &BodyParameters) {
        self.mass_inverse = 1.0 / parameters.laden_mass_kg();
    }

    /// The orientation of the body's axes in the fixed frame.
    #[inline]
    pub fn rotation(&self) -> Rotation {
        self.rotation
    }

    /// A point of the body, from the axle's midpoint, in the fixed frame \[m\].
    #[inline]
    pub fn point_m(&self, forward_m: f64, left_m: f64) -> (f64, f64) {
        let (x, y) = (forward_m - self.center_x_m, left_m - self.center_y_m);
        let (x, y) = self.rotation.apply(x, y);
        (self.x_m + x, self.y_m + y)
    }

    pub fn pose(&self) -> Pose {
        let (offset_x, offset_y) = self.rotation.apply(self.center_x_m, self.center_y_m);
        Pose { x_m: self.x_m - offset_x, y_m: self.y_m - offset_y, heading_rad: self.heading_rad }
    }

    /// The axle midpoint's motion.
    #[inline]
    pub fn twist(&self) -> Twist {
        Twist {
            forward_mps: self.u_mps + self.yaw_rate_rad_s * self.center_y_m,
            left_mps: self.v_mps - self.yaw_rate_rad_s * self.center_x_m,
            yaw_rate_rad_s: self.yaw_rate_rad_s,
        }
    }

    /// Kinetic energy \[J\].
    pub fn energy_j(&self) -> f64 {
        0.5 * (self.u_mps * self.u_mps + self.v_mps * self.v_mps) / self.mass_inverse
            + 0.5 * self.yaw_rate_rad_s * self.yaw_rate_rad_s / self.inertia_inverse
    }

    /// Changes the momentum: m dv = F h, I domega = M h.
    #[inline]
    pub fn kick(&mut self, wrench: Wrench, h_s: f64) {
        let (ax, ay) = (wrench.forward_n * self.mass_inverse, wrench.left_n * self.mass_inverse);
        self.acceleration_mps2 = (ax, ay);
        self.u_mps += ax * h_s;
        self.v_mps += ay * h_s;
        self.yaw_rate_rad_s += wrench.yaw_nm * self.inertia_inverse * h_s;
    }

    /// Stops a body that moves by less than 1e-10 m/s.
    ///
    /// The last vibration in the tyres decays exponentially. Without this, the numbers would become
    /// subnormal, which slows the processor down.
    #[inline]
    pub fn settle(&mut self) {
        const STILL: f64 = 1e-10;
        if self.u_mps.abs() < STILL && self.v_mps.abs() < STILL && self.yaw_rate_rad_s.abs() < STILL
        {
            (self.u_mps, self.v_mps, self.yaw_rate_rad_s) = (0.0, 0.0, 0.0);
        }
    }

    /// Moves the body for h with its present momentum, and returns the axle midpoint's motion halfway.
    ///
    /// The velocity is constant in the fixed frame, so its components in the body's axes turn the
    /// other way. Their mean stands for the middle of the step (off by (omega h)^2 / 8).
    #[inline]
    pub fn drift(&mut self, h_s: f64) -> Twist {
        let turn_rad = self.yaw_rate_rad_s * h_s;
        let before = self.twist();
        let (vx, vy) = self.rotation.apply(self.u_mps, self.v_mps);
        self.x_m += vx * h_s;
        self.y_m += vy * h_s;
        self.heading_rad += turn_rad;
        let turn = Rotation::small(turn_rad);
        self.rotation = self.rotation.then(turn);
        (self.u_mps, self.v_mps) = turn.undo(self.u_mps, self.v_mps);
        let after = self.twist();
        Twist {
            forward_mps: 0.5 * (before.forward_mps + after.forward_mps),
            left_mps: 0.5 * (before.left_mps + after.left_mps),
            yaw_rate_rad_s: self.yaw_rate_rad_s,
        }
    }
}
