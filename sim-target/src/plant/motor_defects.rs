//! What real motors and their gears have besides one dry and one viscous friction.

use core::f64::consts::TAU;

use serde::{Deserialize, Serialize};
use shared_proto::WheelPair;

use super::motor::MotorParameters;
use super::range_check::{ParameterError, RangeCheck};
use super::wheel::DrivenWheel;

/// Resistance of copper by temperature \[1/K\].
const COPPER_PER_K: f64 = 0.0039;

/// The defects of one motor and its gear, torques at the wheel. All zero is a perfect motor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotorDefectParameters {
    /// Friction beyond the dry one that holds a wheel at rest \[N m\].
    pub stiction_nm: f64,
    /// Friction beyond the dry one at low speed, until a film of grease builds up \[N m\].
    pub boundary_nm: f64,
    /// Speed of the wheel at which the film carries \[rad/s\].
    pub film_rad_s: f64,
    /// Friction that is higher forwards than backwards, half the difference \[N m\].
    pub one_way_nm: f64,
    /// Brushes off their neutral line: the torque constant is larger forwards by this share, and smaller backwards.
    pub brush_lead: f64,
    /// Torque of the magnets that holds the rotor in its slots, amplitude \[N m\].
    pub cogging_nm: f64,
    /// Slots per turn of the wheel.
    pub cogging_slots: f64,
    /// Angle of the wheel at the middle of a slot \[rad\].
    pub cogging_phase_rad: f64,
    /// Drag by the square of the speed \[N m s^2/rad^2\].
    pub drag_nms2: f64,
    /// From the winding to the room \[K/W\]; 0 for a winding that does not warm.
    pub heat_resistance_k_per_w: f64,
    /// Heat that the winding takes up \[J/K\].
    pub heat_capacity_j_per_k: f64,
    /// A tooth that binds once per turn of the wheel \[N m\].
    pub tight_tooth_nm: f64,
    /// Share of a turn in which it does.
    pub tight_tooth_share: f64,
    /// Friction of the gear in proportion to the torque that it carries.
    pub gear_loss: f64,
    /// Speed of the wheel beyond which brushes lift off, and resistance grows by the excess; 0: they stay \[rad/s\].
    pub brush_lift_rad_s: f64,
}

impl Default for MotorDefectParameters {
    fn default() -> Self {
        Self {
            stiction_nm: 0.0,
            boundary_nm: 0.0,
            film_rad_s: 1.0,
            one_way_nm: 0.0,
            brush_lead: 0.0,
            cogging_nm: 0.0,
            cogging_slots: 12.0,
            cogging_phase_rad: 0.0,
            drag_nms2: 0.0,
            heat_resistance_k_per_w: 0.0,
            heat_capacity_j_per_k: 10.0,
            tight_tooth_nm: 0.0,
            tight_tooth_share: 0.05,
            gear_loss: 0.0,
            brush_lift_rad_s: 0.0,
        }
    }
}

impl MotorDefectParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        check.within("stiction_nm", self.stiction_nm, 0.0, 100.0)?;
        check.within("boundary_nm", self.boundary_nm, 0.0, 100.0)?;
        check.within("film_rad_s", self.film_rad_s, 1e-3, 1e3)?;
        check.within("one_way_nm", self.one_way_nm, -100.0, 100.0)?;
        check.within("brush_lead", self.brush_lead, -0.5, 0.5)?;
        check.within("cogging_nm", self.cogging_nm, 0.0, 100.0)?;
        check.within("cogging_slots", self.cogging_slots, 0.1, 1e4)?;
        check.within("cogging_phase_rad", self.cogging_phase_rad, -7.0, 7.0)?;
        check.within("drag_nms2", self.drag_nms2, 0.0, 100.0)?;
        check.within("heat_resistance_k_per_w", self.heat_resistance_k_per_w, 0.0, 1e3)?;
        check.within("heat_capacity_j_per_k", self.heat_capacity_j_per_k, 1e-3, 1e6)?;
        check.within("tight_tooth_nm", self.tight_tooth_nm, 0.0, 100.0)?;
        check.within("tight_tooth_share", self.tight_tooth_share, 1e-3, 1.0)?;
        check.within("gear_loss", self.gear_loss, 0.0, 0.9)?;
        check.within("brush_lift_rad_s", self.brush_lift_rad_s, 0.0, 1e4)
    }

    fn is_ideal(&self) -> bool {
        *self
            == Self {
                film_rad_s: self.film_rad_s,
                cogging_slots: self.cogging_slots,
                cogging_phase_rad: self.cogging_phase_rad,
                heat_capacity_j_per_k: self.heat_capacity_j_per_k,
                tight_tooth_share: self.tight_tooth_share,
                ..Self::default()
            }
    }
}

/// One motor with defects.
#[derive(Clone, Copy, Debug)]
pub(super) struct DefectiveMotor {
    parameters: MotorDefectParameters,
    motor: MotorParameters,
    /// Of the winding, above the room's \[K\].
    warmer_k: f64,
}

impl DefectiveMotor {
    /// None if both motors are perfect.
    pub fn pair(
        defects: WheelPair<MotorDefectParameters>,
        motors: WheelPair<MotorParameters>,
    ) -> Option<Box<WheelPair<Self>>> {
        if defects.all(|defects| defects.is_ideal()) {
            return None;
        }
        let both = defects.zip(motors);
        Some(Box::new(both.map(|(parameters, motor)| Self { parameters, motor, warmer_k: 0.0 })))
    }

    /// Sets a wheel's motor for its next step.
    ///
    /// ```text
    /// friction = T_C + T_rest (at rest) + T_b exp(-|w| / w_f) + gear_loss |K i| + T_1 sgn w + tooth      (1)
    /// push     = -T_cog sin(N (phi - phi_0)) - c w |w|                                                  (2)
    /// K        = K_0 (1 + lead sgn w)                                                                   (3)
    /// R        = R_0 (1 + 0.0039 dT) (1 + lift),   C dT/dt = R i^2 - dT / R_th                          (4)
    /// ```
    pub fn prepare(&mut self, wheel: &mut DrivenWheel, h_s: f64) {
        let Self { parameters: defects, motor, warmer_k } = self;
        let (w, phi) = (wheel.spin_rad_s, wheel.angle_rad);
        let way = if w == 0.0 { 0.0 } else { w.signum() };
        let k = motor.wheel_torque_constant_nm_per_a() * (1.0 + defects.brush_lead * way); // (3)
        let mut friction = motor.coulomb_torque_nm; // (1)
        if w == 0.0 {
            friction += defects.stiction_nm;
        }
        friction += defects.boundary_nm * (-w.abs() / defects.film_rad_s).exp();
        friction += defects.gear_loss * (k * wheel.current_a).abs() + defects.one_way_nm * way;
        if (phi / TAU).rem_euclid(1.0) < defects.tight_tooth_share {
            friction += defects.tight_tooth_nm;
        }
        let slot_rad = defects.cogging_slots * (phi - defects.cogging_phase_rad);
        let push = -defects.cogging_nm * slot_rad.sin() - defects.drag_nms2 * w * w.abs(); // (2)
        let mut resistance = motor.resistance_ohm; // (4)
        if defects.heat_resistance_k_per_w > 0.0 {
            resistance *= 1.0 + COPPER_PER_K * *warmer_k;
            let heat_w = resistance * wheel.current_a * wheel.current_a;
            let lost_w = *warmer_k / defects.heat_resistance_k_per_w;
            *warmer_k += h_s * (heat_w - lost_w) / defects.heat_capacity_j_per_k;
        }
        if defects.brush_lift_rad_s > 0.0 {
            resistance *= 1.0 + (w.abs() / defects.brush_lift_rad_s - 1.0).max(0.0);
        }
        wheel.coulomb_nm = friction.max(0.0);
        wheel.push_nm = push;
        wheel.motor.torque_constant = k;
        wheel.motor.conductance = 1.0 / resistance;
    }
}
