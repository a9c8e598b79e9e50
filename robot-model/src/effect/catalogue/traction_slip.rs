//! A driven tyre slips in proportion to the force it passes on, hence to the acceleration.
//!
//! ```text
//! ds_i -> ds_i (1 - c a_i sgn v_i)
//! ```
//!
//! c \[s^2/m\] > 0: less travel than counted when accelerating, more when braking.

use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// Driving forces make the tyres slip.
#[derive(Debug)]
pub struct TractionSlip;

impl Effect for TractionSlip {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let travel = step.wheel_accel_mps2.zip(step.wheel_speed_mps);
        let travel = travel.map(|(accel, speed)| p[0] * (-accel * speed.signum()));
        Change { travel, ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "traction_slip",
    name: "slip under traction",
    equation: "ds_i (1 - c a_i sgn v_i)",
    parameters: &[Parameter::positive("c", "s^2/m", 0.2)],
    signature: "an error that arises only on speed ramps",
    shown_by: "fast and slow ramps",
    compensation: "lower the acceleration limit, or add this term to the odometry",
    ..Facts::DEFAULT
};
