//! A motor driver swallows small voltages: dead time, a threshold.
//!
//! ```text
//! V -> sgn V max(0, |V| - V_0)
//! ```
//!
//! V_0 \[V\] > 0: of each voltage that is commanded, so much is missing. When the robot drives that is the same as friction; when
//! it rolls out it is not, since then nothing is swallowed.

use super::definition::{Acting, Moment, MotorEffect, MotorFacts, MotorParameter};

/// The driver swallows small voltages.
#[derive(Debug)]
pub struct DeadBand;

impl MotorEffect for DeadBand {
    fn facts(&self) -> MotorFacts<'_> {
        FACTS
    }

    fn act(&self, p: &[f64], moment: &Moment, acting: &mut Acting) {
        let volts = moment.volts.0;
        acting.volts -= volts.clamp(-p[0], p[0]);
    }

    /// 0.03 to 0.046 mm in eight of 82 simulated robots with another effect.
    fn imitated_m(&self) -> f64 {
        5e-5
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "dead_band",
    name: "the motor driver has a dead band",
    equation: "sgn V max(0, |V| - V_0)",
    parameters: &[MotorParameter::positive("V_0", "V", 0.1, 6.0)],
    sign: "so much of each voltage is missing",
    shown_by: "rolling out after steps, against driving",
    remedy: "add V_0 to each voltage that is not zero",
};
