//! The motor driver.

use serde::{Deserialize, Serialize};

use super::motor::Motor;
use super::range_check::{ParameterError, RangeCheck};

/// What differs between motor drivers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BridgeParameters {
    /// Disabled, the driver shorts the motors, so that they brake; otherwise their terminals are open.
    pub shorts_when_off: bool,
    /// Enabled and without a duty, the driver opens the motors' terminals, so that they coast; otherwise it shorts them.
    pub opens_without_duty: bool,
    /// From a new duty to its effect, in calls of [`Plant::set_duty`](super::Plant::set_duty): the robot makes one a
    /// millisecond.
    pub delay_ms: u8,
    /// Voltage that is lost to dead times of the switches, of each duty that is not zero \[V\].
    pub dead_band_v: f64,
    /// Motor current at which the driver chops; absent for one that does not \[A\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub current_limit_a: Option<f64>,
    /// How much the mean voltage bends below the duty's straight line, or above it: the voltage is the supply times duty to the
    /// power of 1 + this.
    pub bend: f64,
    /// How fast the duty on the motors can change; absent for a driver that follows at once \[1/s\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slew_per_s: Option<f64>,
}

impl BridgeParameters {
    pub(super) fn check(&self, check: &RangeCheck) -> Result<(), ParameterError> {
        check.within("dead_band_v", self.dead_band_v, 0.0, 50.0)?;
        check.within("current_limit_a", self.current_limit_a.unwrap_or(1.0), 1e-3, 1e4)?;
        check.within("bend", self.bend, -0.5, 5.0)?;
        check.within("slew_per_s", self.slew_per_s.unwrap_or(1.0), 1e-2, 1e6)
    }

    pub(super) fn is_ideal(&self) -> bool {
        self.dead_band_v == 0.0 && self.current_limit_a.is_none() && self.bend == 0.0
    }

    /// The duty on a motor after a step of h, on the way to what is commanded.
    pub(super) fn slewed(&self, duty: f64, commanded: f64, h_s: f64) -> f64 {
        let Some(slew_per_s) = self.slew_per_s else { return commanded };
        let most = slew_per_s * h_s;
        duty + (commanded - duty).clamp(-most, most)
    }

    /// The share of the supply that a duty really gives, where the supply is at `bus_v` and the motor turns.
    pub(super) fn share(&self, duty: f64, bus_v: f64, motor: &Motor, spin_rad_s: f64) -> f64 {
        if bus_v <= 0.0 {
            return duty;
        }
        let size = duty.abs().powf(1.0 + self.bend);
        let mut share = (size - self.dead_band_v / bus_v).max(0.0).copysign(duty);
        if let Some(limit_a) = self.current_limit_a {
            let emf = motor.torque_constant * spin_rad_s / bus_v;
            let room = limit_a / (motor.conductance * bus_v);
            share = share.clamp(emf - room, emf + room).clamp(-1.0, 1.0);
        }
        share
    }
}
