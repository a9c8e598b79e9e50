//! The motors of the two sides differ.
//!
//! ```text
//! kS (1 + a m) sgn v + kV (1 + b m) v          m: 1 for the left wheel, -1 for the right
//! ```
//!
//! a, b \[1\] > 0: the left motor has more friction, or is slower at the same voltage.

use super::definition::{Acting, Moment, MotorEffect, MotorFacts, MotorParameter};

/// Left and right motor differ.
#[derive(Debug)]
pub struct SideAsymmetry;

impl MotorEffect for SideAsymmetry {
    fn facts(&self) -> MotorFacts<'_> {
        FACTS
    }

    fn act(&self, p: &[f64], moment: &Moment, acting: &mut Acting) {
        acting.scale_friction(1.0 + p[0] * moment.side);
        acting.motor.kv_v_s_per_m *= 1.0 + p[1] * moment.side;
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "side_asymmetry",
    name: "the motors of the two sides differ",
    equation: "kS (1 + a m) sgn v + kV (1 + b m) v, m = 1 left, -1 right",
    parameters: &[
        MotorParameter::amplitude("a", "1", 0.1, 0.9),
        MotorParameter::amplitude("b", "1", 0.02, 0.5),
    ],
    sign: "the left motor has more friction (a), or is slower (b)",
    shown_by: "steps straight on at several voltages",
    remedy: "feedforward by wheel, which `beeline tune` sets",
};
