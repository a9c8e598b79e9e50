//! Something pushes the robot along its way: a slope, a cable.
//!
//! ```text
//! V + e cos h + f sin h                       h: heading since the campaign began, left positive, by the counters
//! ```
//!
//! e \[V\] > 0: both wheels are pushed forwards, as the robot stood at first; f \[V\] > 0: to the left. Only a robot that turns
//! shows f. A cable that turns with the robot pushes the same way at every heading: of such a robot, one that turns little.

use super::definition::{Acting, Moment, MotorEffect, MotorFacts, MotorParameter};

/// A push on both wheels, constant on the floor.
#[derive(Debug)]
pub struct LoadTorque;

impl MotorEffect for LoadTorque {
    fn facts(&self) -> MotorFacts<'_> {
        FACTS
    }

    fn act(&self, p: &[f64], moment: &Moment, acting: &mut Acting) {
        let (sin, cos) = moment.heading_rad.sin_cos();
        acting.volts += p[0] * cos + p[1] * sin;
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "load_torque",
    name: "something pushes the robot along its way",
    equation: "V + e cos h + f sin h, both wheels alike; h: heading",
    parameters: &[
        MotorParameter::amplitude("e", "V", 0.1, 3.0),
        MotorParameter::amplitude("f", "V", 0.1, 3.0),
    ],
    sign: "pushed forwards",
    shown_by: "steps both ways",
    remedy: "a level floor, no cable; turned round, a slope pushes the other way",
};
