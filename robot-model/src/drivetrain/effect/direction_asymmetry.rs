//! A motor runs easier one way: brushes set off their neutral line, a gear with slanted teeth.
//!
//! ```text
//! e m + kV (1 + d m sgn v) v                   m: 1 for the left wheel, -1 for the right
//! ```
//!
//! e \[V\], d \[1\] > 0: forwards is harder for the left motor and easier for the right one. The motors are mounted mirrored, so
//! what one prefers forwards the other prefers backwards. A push on the robot is the same for both (`load_torque`).

use super::definition::{Acting, Moment, MotorEffect, MotorFacts, MotorParameter};

/// Motors run easier one way.
#[derive(Debug)]
pub struct DirectionAsymmetry;

impl MotorEffect for DirectionAsymmetry {
    fn facts(&self) -> MotorFacts<'_> {
        FACTS
    }

    fn act(&self, p: &[f64], moment: &Moment, acting: &mut Acting) {
        acting.volts -= p[0] * moment.side;
        let way = moment.speed_mps.0.signum();
        acting.motor.kv_v_s_per_m *= 1.0 + p[1] * moment.side * way;
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "direction_asymmetry",
    name: "the motors run more easily one way",
    equation: "e m + kV (1 + d m sgn v) v, m = 1 left, -1 right",
    parameters: &[
        MotorParameter::amplitude("e", "V", 0.1, 3.0),
        MotorParameter::amplitude("d", "1", 0.02, 0.5),
    ],
    sign: "forwards is harder for the left motor, backwards for the right one",
    shown_by: "steps both ways, straight on and on the spot",
    remedy: "feedforward by wheel and direction, which `beeline tune` sets",
};
