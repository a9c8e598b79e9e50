//! The supply falls under load, and nobody measures it.
//!
//! ```text
//! V_i -> V_i (1 - c sum_j V_j (V_j - kV v_j))      j: both motors
//! ```
//!
//! c \[1/V^2\] > 0: the currents of both motors, which are as V - kV v, lower the voltage. Where the supply is logged, it is an
//! input and nothing is left of this.

use super::definition::{Acting, Moment, MotorEffect, MotorFacts, MotorParameter};

/// An unmeasured supply that falls under load.
#[derive(Debug)]
pub struct SupplySag;

impl MotorEffect for SupplySag {
    fn facts(&self) -> MotorFacts<'_> {
        FACTS
    }

    fn act(&self, p: &[f64], moment: &Moment, acting: &mut Acting) {
        let kv = acting.motor.kv_v_s_per_m;
        let load = |volts: f64, speed_mps: f64| volts * (volts - kv * speed_mps);
        let both =
            load(moment.volts.0, moment.speed_mps.0) + load(moment.volts.1, moment.speed_mps.1);
        acting.volts -= p[0] * both * moment.volts.0;
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "supply_sag",
    name: "the supply sags under load",
    equation: "V_i (1 - c sum_j V_j (V_j - kV v_j))",
    parameters: &[MotorParameter::positive("c", "1/V^2", 2e-4, 2e-2)],
    sign: "the more both motors draw, the less is left",
    shown_by: "steps at full voltage, of one wheel and of both",
    remedy: "measure the supply (protection.supply_v_min above 0), or use thicker wires and a stronger battery",
};
