//! The yaw rate sensor shows a rate at rest.
//!
//! ```text
//! gyro = omega + bias
//! ```
//!
//! bias \[rad/s\], counter-clockwise positive.

use crate::effect::definition::{ActsOn, Effect, Facts, Need, Parameter};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};

/// The yaw rate sensor is off at rest.
#[derive(Debug)]
pub struct GyroBias;

impl Effect for GyroBias {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn sense_rate(&self, p: &[Jet; PARAMETERS_MAX], _turn_rate_rad_s: f64) -> Jet {
        p[0]
    }
}

static FACTS: Facts<'static> = Facts {
    id: "gyro_bias",
    name: "gyro bias",
    equation: "gyro = omega + bias",
    parameters: &[Parameter::amplitude("bias", "rad/s", 0.2)],
    acts_on: ActsOn::Gyro,
    signature: "the gyro's heading drifts with time",
    shown_by: "a run at rest",
    compensation: "subtract the bias",
    needs: &[Need::YawRate],
    ..Facts::DEFAULT
};
