//! The yaw rate sensor is off in proportion.
//!
//! ```text
//! gyro = omega (1 + k)
//! ```
//!
//! k > 0: it shows too much.

use crate::effect::definition::{ActsOn, Effect, Facts, Need, Parameter};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};

/// The yaw rate sensor shows too much or too little.
#[derive(Debug)]
pub struct GyroScale;

impl Effect for GyroScale {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn sense_rate(&self, p: &[Jet; PARAMETERS_MAX], turn_rate_rad_s: f64) -> Jet {
        p[0] * turn_rate_rad_s
    }
}

static FACTS: Facts<'static> = Facts {
    id: "gyro_scale",
    name: "gyro scale error",
    equation: "gyro = omega (1 + k)",
    parameters: &[Parameter::amplitude("k", "1", 0.1).possible(-1.0, f64::INFINITY)],
    acts_on: ActsOn::Gyro,
    signature: "the gyro's heading is off in proportion to the rotation",
    shown_by: "spins",
    compensation: "divide the yaw rate by 1 + k",
    needs: &[Need::YawRate],
    ..Facts::DEFAULT
};
