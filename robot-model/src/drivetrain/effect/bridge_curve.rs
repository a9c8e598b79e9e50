//! The mean voltage of a motor driver is not straight in its duty.
//!
//! ```text
//! V -> V (1 - b / (1 + |V| / V_b))
//! ```
//!
//! b \[1\] > 0: small voltages give less, as where the current stops before the next pulse; < 0: more. V_b \[V\]: far beyond it
//! the line is straight. A line that is straight with another slope cannot be told from kV at one supply.

use super::definition::{Acting, Excitation, Moment, MotorEffect, MotorFacts, MotorParameter};

/// A driver whose voltage is not straight in the duty.
#[derive(Debug)]
pub struct BridgeCurve;

impl MotorEffect for BridgeCurve {
    fn facts(&self) -> MotorFacts<'_> {
        FACTS
    }

    fn act(&self, p: &[f64], moment: &Moment, acting: &mut Acting) {
        let volts = moment.volts.0;
        acting.volts -= p[0] * volts / (1.0 + volts.abs() / p[1]);
    }

    fn starts(&self, _excitation: &Excitation) -> Vec<Vec<f64>> {
        [1.0, 3.0, 9.0].map(|bend_v| vec![0.0, bend_v]).into()
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "bridge_curve",
    name: "the motor driver's voltage is not straight in the duty",
    equation: "V (1 - b / (1 + |V| / V_b))",
    // Below 1 more duty always gives more voltage.
    parameters: &[
        MotorParameter::amplitude("b", "1", 0.05, 0.95),
        MotorParameter::shape("V_b", "V", 0.2, 60.0),
    ],
    sign: "small voltages give less",
    shown_by: "steps to eight different voltages",
    remedy: "a driver with slow decay, or divide by 1 - b / (1 + |V| / V_b)",
};
