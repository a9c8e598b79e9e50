//! Drag that grows with the square of the speed: air, churned grease.
//!
//! ```text
//! q v |v|
//! ```
//!
//! q \[V s^2/m^2\] > 0: more drag when fast.

use super::definition::{Acting, Moment, MotorEffect, MotorFacts, MotorParameter};

/// Drag by the square of the speed.
#[derive(Debug)]
pub struct QuadraticDrag;

impl MotorEffect for QuadraticDrag {
    fn facts(&self) -> MotorFacts<'_> {
        FACTS
    }

    fn act(&self, p: &[f64], moment: &Moment, acting: &mut Acting) {
        let v = moment.speed_mps.0;
        acting.volts -= p[0] * v * v.abs();
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "quadratic_drag",
    name: "drag grows with the square of the speed",
    equation: "q v |v|",
    parameters: &[MotorParameter::positive("q", "V s^2/m^2", 1.0, 200.0)],
    sign: "more drag when fast",
    shown_by: "steps up to the top speed",
    remedy: "add q v |v| to the feedforward, or tune at the speed of use",
};
