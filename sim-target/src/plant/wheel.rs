//! A driven wheel on its axle: motor on one side, tyre on the other, friction in between.

use serde::{Deserialize, Serialize};
use shared_proto::WheelPair;

use super::motor::{Motor, MotorParameters, Terminals};
use super::range_check::{ParameterError, RangeCheck};
use super::tyre::Contact;

/// Radii, track and inertia of the driven wheels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GeometryParameters {
    /// Rolling radius of each wheel, R_L and R_R \[m\].
    pub wheel_radius_m: WheelPair<f64>,
    /// Distance between the contact points, b \[m\].
    pub track_width_m: f64,
    /// Inertia of one wheel about its axle, without the rotor \[kg m^2\].
    pub wheel_inertia_kgm2: f64,
}

impl Default for GeometryParameters {
    /// The paper's nominal robot.
    fn default() -> Self {
        Self {
            wheel_radius_m: WheelPair::both(0.036),
            track_width_m: 0.372,
            wheel_inertia_kgm2: 1e-4,
        }
    }
}

impl GeometryParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        check.within("wheel_radius_m.left", self.wheel_radius_m.left, 0.002, 2.0)?;
        check.within("wheel_radius_m.right", self.wheel_radius_m.right, 0.002, 2.0)?;
        check.within("track_width_m", self.track_width_m, 0.01, 10.0)?;
        check.within("wheel_inertia_kgm2", self.wheel_inertia_kgm2, 1e-8, 10.0)
    }
}

/// One driven wheel.
///
/// ```text
/// J dw/dt = K i - B w - R F_x - friction          (1)  J: wheel and n^2 rotors
/// |friction| <= T_C + f N R + clamp               (2)  holds a wheel at rest, opposes one that turns
/// ```
#[derive(Clone, Copy, Debug)]
pub(super) struct DrivenWheel {
    pub motor: Motor,
    pub radius_m: f64,
    inertia_inverse: f64,
    pub viscous: f64,
    pub coulomb_nm: f64,
    pub rolling_nm: f64,
    /// Torque of the motor besides its current's; a negative zero changes no bit of any sum \[N m\].
    pub push_nm: f64,
    /// Contact point to the left of the midline \[m\].
    pub left_m: f64,
    pub angle_rad: f64,
    pub spin_rad_s: f64,
    pub current_a: f64,
    pub contact: Contact,
}

impl DrivenWheel {
    pub fn new(motor: &MotorParameters, radius_m: f64, wheel_inertia: f64, left_m: f64) -> Self {
        Self {
            motor: Motor::new(motor),
            radius_m,
            inertia_inverse: 1.0 / (wheel_inertia + motor.rotor_at_wheel_kgm2()),
            viscous: motor.viscous_torque_nms,
            coulomb_nm: motor.coulomb_torque_nm,
            rolling_nm: 0.0,
            push_nm: -0.0,
            left_m,
            angle_rad: 0.0,
            spin_rad_s: 0.0,
            current_a: 0.0,
            contact: Contact::default(),
        }
    }

    /// Advances the spin by h: (1) by the trapezoidal rule, friction (2) as a bounded impulse. A wheel that
    /// friction can stop is stopped exactly, and stays at rest.
    #[inline]
    pub fn kick(&mut self, terminals: Terminals, bus_v: f64, clamp_nm: f64, h_s: f64) {
        let k = self.motor.torque_constant;
        let (voltage_v, conductance) = match terminals {
            Terminals::Open => (0.0, 0.0),
            Terminals::Driven(duty) => (duty * bus_v, self.motor.conductance),
        };
        let before = self.spin_rad_s;
        let torque_nm =
            k * conductance * voltage_v - self.radius_m * self.contact.force_n.0 + self.push_nm;
        let damping = 0.5 * h_s * self.inertia_inverse * (k * k * conductance + self.viscous);
        let scale = 1.0 / (1.0 + damping);
        let per_torque = h_s * self.inertia_inverse * scale;
        let free = before * (1.0 - damping) * scale + torque_nm * per_torque;
        let friction = (self.coulomb_nm + self.rolling_nm + clamp_nm) * per_torque;
        let after = less_friction(free, friction);
        self.spin_rad_s = after;
        self.current_a = conductance * (voltage_v - k * 0.5 * (before + after));
    }

    /// Turns by h at the present spin.
    #[inline]
    pub fn drift(&mut self, h_s: f64) {
        self.angle_rad += self.spin_rad_s * h_s;
    }

    /// Resets contact and motion.
    pub fn lift(&mut self) {
        self.contact = Contact::default();
        self.spin_rad_s = 0.0;
    }

    /// Takes up the rolling resistance of a load, f N R.
    #[inline]
    pub fn set_load(&mut self, rolling_resistance: f64, load_n: f64) {
        self.rolling_nm = rolling_resistance * load_n * self.radius_m;
    }

    /// Kinetic energy of wheel and rotor \[J\].
    pub fn energy_j(&self) -> f64 {
        0.5 * self.spin_rad_s * self.spin_rad_s / self.inertia_inverse
    }
}

/// A speed after dry friction, which reduces the speed towards zero by at most `limit`.
#[inline]
pub(super) fn less_friction(free: f64, limit: f64) -> f64 {
    free - free.clamp(-limit, limit)
}
