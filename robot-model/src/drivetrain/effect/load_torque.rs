//! Something pushes the robot along its way: a slope, a cable.
//!
//! ```text
//! V + e
//! ```
//!
//! e \[V\] > 0: both wheels are pushed forwards.

use super::definition::{Acting, Moment, MotorEffect, MotorFacts, MotorParameter};

/// A constant push on both wheels.
#[derive(Debug)]
pub struct LoadTorque;

impl MotorEffect for LoadTorque {
    fn facts(&self) -> &'static MotorFacts {
        &FACTS
    }

    fn act(&self, p: &[f64], _moment: &Moment, acting: &mut Acting) {
        acting.volts += p[0];
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "load_torque",
    name: "something pushes the robot along its way",
    equation: "V + e, both wheels alike",
    parameters: &[MotorParameter::amplitude("e", "V", 0.1, 3.0)],
    sign: "pushed forwards",
    shown_by: "steps both ways",
    confounded_with: &["direction_asymmetry"],
    remedy: "a level floor, no cable; turned round, a slope pushes the other way",
};
