//! The mean voltage of a motor driver is not straight in its duty.
//!
//! ```text
//! V -> V (1 - b (1 - |V| / V_full) / (1 + |V| / V_b))      V_full: the highest voltage of the campaign
//! ```
//!
//! b \[1\] > 0: this share of small voltages is missing, as where the current stops before the next pulse; < 0: there is more.
//! Nothing is missing at the highest voltage: a line that is straight with another slope cannot be told from kV. V_b \[V\]: where
//! half of the bend is over, if it is much less than V_full.

use super::definition::{Acting, Excitation, Moment, MotorEffect, MotorFacts, MotorParameter};

/// A driver whose voltage is not straight in the duty.
#[derive(Debug)]
pub struct BridgeCurve;

impl MotorEffect for BridgeCurve {
    fn facts(&self) -> MotorFacts<'_> {
        FACTS
    }

    fn act(&self, p: &[f64], moment: &Moment, acting: &mut Acting) {
        let (volts, size_v) = (moment.volts.0, moment.volts.0.abs());
        let share = (1.0 - size_v / moment.full_v).max(0.0) / (1.0 + size_v / p[1]);
        acting.volts -= p[0] * share * volts;
    }

    fn starts(&self, _excitation: &Excitation) -> Vec<Vec<f64>> {
        [1.0, 3.0, 9.0].map(|bend_v| vec![0.0, bend_v]).into()
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "bridge_curve",
    name: "the motor driver's voltage is not straight in the duty",
    equation: "V (1 - b (1 - |V| / V_full) / (1 + |V| / V_b)), V_full: the highest voltage recorded",
    // Below 1 more duty always gives more voltage.
    parameters: &[
        MotorParameter::amplitude("b", "1", 0.05, 0.95),
        MotorParameter::shape("V_b", "V", 0.2, 60.0),
    ],
    sign: "a share of small voltages is missing",
    shown_by: "steps to eight different voltages",
    remedy: "a motor driver that brakes between its pulses (slow decay), or a table of the duty by the voltage that it gives",
};
