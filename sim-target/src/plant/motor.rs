//! A direct-current gear motor behind a PWM bridge.

use serde::{Deserialize, Serialize};

use super::range_check::{ParameterError, RangeCheck};

/// One wheel's gear motor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MotorParameters {
    /// Resistance of winding, brushes and bridge, R \[ohm\].
    pub resistance_ohm: f64,
    /// Torque constant, equal to the back-EMF constant, at the motor's shaft, k \[N m/A = V s/rad\].
    pub torque_constant_nm_per_a: f64,
    /// Motor turns per wheel turn, n.
    pub gear_ratio: f64,
    /// Inertia of the rotor, at the motor's shaft \[kg m^2\].
    pub rotor_inertia_kgm2: f64,
    /// Dry friction of motor and gear, at the wheel \[N m\].
    pub coulomb_torque_nm: f64,
    /// Friction proportional to speed, at the wheel \[N m s/rad\].
    pub viscous_torque_nms: f64,
    /// True if the motor is wired so that a positive duty turns the wheel backwards.
    pub reversed: bool,
}

impl Default for MotorParameters {
    /// A 12 V gear motor: 2.2 turns/s without load, 1.5 N m stalled, moving from 4 % duty.
    fn default() -> Self {
        Self {
            resistance_ohm: 6.8,
            torque_constant_nm_per_a: 0.0283,
            gear_ratio: 30.0,
            rotor_inertia_kgm2: 8e-7,
            coulomb_torque_nm: 0.05,
            viscous_torque_nms: 5e-4,
            reversed: false,
        }
    }
}

impl MotorParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        check.within("resistance_ohm", self.resistance_ohm, 0.01, 1000.0)?;
        check.within("torque_constant_nm_per_a", self.torque_constant_nm_per_a, 1e-4, 10.0)?;
        check.within("gear_ratio", self.gear_ratio, 1.0, 1000.0)?;
        check.within("rotor_inertia_kgm2", self.rotor_inertia_kgm2, 0.0, 1.0)?;
        check.within("coulomb_torque_nm", self.coulomb_torque_nm, 0.0, 100.0)?;
        check.within("viscous_torque_nms", self.viscous_torque_nms, 0.0, 100.0)
    }

    /// The rotor's inertia, seen from the wheel \[kg m^2\].
    pub(super) fn rotor_at_wheel_kgm2(&self) -> f64 {
        self.rotor_inertia_kgm2 * self.gear_ratio * self.gear_ratio
    }

    /// Torque constant at the wheel, K = k n \[N m/A\].
    pub fn wheel_torque_constant_nm_per_a(&self) -> f64 {
        self.torque_constant_nm_per_a * self.gear_ratio
    }
}

/// How the motor's terminals are connected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Terminals {
    /// Open: no current flows.
    Open,
    /// Connected to the supply for this share of the time, shorted for the rest: mean voltage duty x bus.
    Driven(f64),
}

/// The electrical side. Inductance is left out: the current follows the voltage within a millisecond.
///
/// ```text
/// i = (d V - K w) / R                             (1)
/// torque at the wheel = K i                       (2)
/// current drawn from the bus = d i                (3)
/// ```
#[derive(Clone, Copy, Debug)]
pub(super) struct Motor {
    /// K, at the wheel \[N m/A\].
    pub torque_constant: f64,
    /// 1/R \[1/ohm\].
    pub conductance: f64,
    /// The voltage's sign at the terminals.
    pub polarity: f64,
}

impl Motor {
    pub fn new(parameters: &MotorParameters) -> Self {
        Self {
            torque_constant: parameters.wheel_torque_constant_nm_per_a(),
            conductance: 1.0 / parameters.resistance_ohm,
            polarity: if parameters.reversed { -1.0 } else { 1.0 },
        }
    }

    /// The motor's load on the bus, as (d^2/R, d K w/R): d i = V d^2/R - d K w/R.
    #[inline]
    pub fn bus_load(&self, terminals: Terminals, spin_rad_s: f64) -> (f64, f64) {
        match terminals {
            Terminals::Open => (0.0, 0.0),
            Terminals::Driven(duty) => {
                let share = duty * self.conductance;
                (duty * share, share * self.torque_constant * spin_rad_s)
            }
        }
    }
}
