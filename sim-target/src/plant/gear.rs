//! The joint between motor and wheel: a gear with play, and a set screw.

use serde::{Deserialize, Serialize};

use super::motor::{Motor, Terminals};
use super::range_check::{ParameterError, RangeCheck};
use super::wheel::less_friction;

/// The joint between one motor, with its encoder, and its wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GearParameters {
    /// Play, from flank to flank, beta, as wheel angle \[rad\].
    pub backlash_rad: f64,
    /// Torque beyond which the wheel slips on its shaft; absent for a screw that holds \[N m\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub set_screw_nm: Option<f64>,
}

impl GearParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        check.within("backlash_rad", self.backlash_rad, 0.0, 1.0)?;
        check.within("set_screw_nm", self.set_screw_nm.unwrap_or(1.0), 1e-4, 1e3)
    }

    pub(super) fn is_ideal(&self) -> bool {
        self.backlash_rad == 0.0 && self.set_screw_nm.is_none()
    }
}

/// The motor's side of a joint that is not rigid. The wheel's side is the driven wheel itself.
///
/// With the motor's side ahead of the wheel by g + s (g within the play, s slipped at the screw):
///
/// ```text
/// J_m dw_m/dt = K i - B w_m - T - friction_m      (1)
/// J_w dw_w/dt = T - R F_x - friction_w            (2)
/// on a flank, g = +-beta/2: w_m = w_w while T presses on that flank and |T| <= T_screw
/// between flanks:           T = 0, g' = w_m - w_w
/// slipping:                 T = +-T_screw, s' = w_m - w_w
/// ```
///
/// Between the flanks the wheel is dragged by the floor alone. Flanks meet without a bounce.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joint {
    half_play_rad: f64,
    screw_nm: f64,
    motor_inertia: f64,
    wheel_inertia: f64,
    play_rad: f64,
    slipped_rad: f64,
    motor_spin_rad_s: f64,
    slipping: bool,
}

/// What acts on both sides of a joint during a step.
pub(super) struct JointLoad {
    pub motor: Motor,
    pub terminals: Terminals,
    pub bus_v: f64,
    pub viscous: f64,
    /// Torque of the motor besides its current's \[N m\].
    pub push_nm: f64,
    /// Dry friction of motor and gear \[N m\].
    pub motor_friction_nm: f64,
    /// Dry friction of the wheel \[N m\].
    pub wheel_friction_nm: f64,
    /// Torque of the floor on the wheel, -R F_x \[N m\].
    pub floor_nm: f64,
}

impl Joint {
    /// None if the joint is rigid.
    pub fn new(gear: &GearParameters, motor_inertia: f64, wheel_inertia: f64) -> Option<Self> {
        (!gear.is_ideal()).then_some(Self {
            half_play_rad: 0.5 * gear.backlash_rad,
            screw_nm: gear.set_screw_nm.unwrap_or(f64::INFINITY),
            motor_inertia,
            wheel_inertia,
            play_rad: 0.0,
            slipped_rad: 0.0,
            motor_spin_rad_s: 0.0,
            slipping: false,
        })
    }

    /// How far the motor's side is ahead of the wheel \[rad\].
    pub fn ahead_rad(&self) -> f64 {
        self.play_rad + self.slipped_rad
    }

    /// Resets the motion.
    pub fn lift(&mut self) {
        (self.motor_spin_rad_s, self.slipping) = (0.0, false);
    }

    /// The flank that carries torque: 1 or -1, 0 in a joint without play, NaN between the flanks.
    #[inline]
    fn flank(&self) -> f64 {
        if self.half_play_rad == 0.0 {
            0.0
        } else if self.play_rad >= self.half_play_rad {
            1.0
        } else if self.play_rad <= -self.half_play_rad {
            -1.0
        } else {
            f64::NAN
        }
    }

    /// Advances both sides by h; the wheel's spin goes in and out. Returns the current \[A\].
    #[inline]
    pub fn kick(&mut self, load: &JointLoad, wheel_spin_rad_s: &mut f64, h_s: f64) -> f64 {
        let k = load.motor.torque_constant;
        let (voltage_v, conductance) = match load.terminals {
            Terminals::Open => (0.0, 0.0),
            Terminals::Driven(duty) => (duty * load.bus_v, load.motor.conductance),
        };
        let drive_nm = k * conductance * voltage_v + load.push_nm;
        let braking = k * k * conductance + load.viscous;
        // A spin after the step, of parts with this inertia under this torque and friction.
        let after = |before: f64, inertia: f64, torque_nm: f64, braking: f64, friction_nm: f64| {
            let damping = 0.5 * h_s * braking / inertia;
            let scale = 1.0 / (1.0 + damping);
            let per_torque = h_s / inertia * scale;
            let free = before * (1.0 - damping) * scale + torque_nm * per_torque;
            less_friction(free, friction_nm * per_torque)
        };
        let (wheel_before, motor_before) = (*wheel_spin_rad_s, self.motor_spin_rad_s);
        let flank = self.flank();
        let touching = !flank.is_nan();
        let mut carried_nm = 0.0;
        if touching && !self.slipping {
            let inertia = self.motor_inertia + self.wheel_inertia;
            let before =
                (self.motor_inertia * motor_before + self.wheel_inertia * wheel_before) / inertia;
            let friction_nm = load.motor_friction_nm + load.wheel_friction_nm;
            let spin = after(before, inertia, drive_nm + load.floor_nm, braking, friction_nm);
            // What the flank must carry for the wheel to follow: (2), T = J_w dw/dt + R F_x + friction.
            let frictionless_nm = self.wheel_inertia * (spin - wheel_before) / h_s - load.floor_nm;
            carried_nm = if spin == 0.0 {
                less_friction(frictionless_nm, load.wheel_friction_nm)
            } else {
                frictionless_nm + load.wheel_friction_nm.copysign(spin)
            };
            let lifts_off = flank * carried_nm < 0.0;
            if !lifts_off && carried_nm.abs() <= self.screw_nm {
                (self.motor_spin_rad_s, *wheel_spin_rad_s) = (spin, spin);
                return conductance * (voltage_v - k * 0.5 * (motor_before + spin));
            }
            self.slipping = !lifts_off;
        }
        let torque_nm = if self.slipping && touching {
            // The screw's friction opposes the slip; its direction at the onset is the torque's.
            let slip = motor_before - wheel_before;
            self.screw_nm.copysign(if carried_nm != 0.0 { carried_nm } else { slip })
        } else {
            0.0
        };
        let motor = after(
            motor_before,
            self.motor_inertia,
            drive_nm - torque_nm,
            braking,
            load.motor_friction_nm,
        );
        let wheel = after(
            wheel_before,
            self.wheel_inertia,
            load.floor_nm + torque_nm,
            0.0,
            load.wheel_friction_nm,
        );
        if self.slipping && (motor - wheel) * torque_nm <= 0.0 {
            self.slipping = false;
        }
        (self.motor_spin_rad_s, *wheel_spin_rad_s) = (motor, wheel);
        conductance * (voltage_v - k * 0.5 * (motor_before + motor))
    }

    /// Advances play and slip by h.
    #[inline]
    pub fn drift(&mut self, wheel_spin_rad_s: f64, h_s: f64) {
        let apart_rad = (self.motor_spin_rad_s - wheel_spin_rad_s) * h_s;
        if self.slipping {
            self.slipped_rad += apart_rad;
        } else {
            self.play_rad =
                (self.play_rad + apart_rad).clamp(-self.half_play_rad, self.half_play_rad);
        }
    }
}
