//! Friction falls as a wheel begins to turn.
//!
//! ```text
//! (kS + k exp(-|v / v_s|^d)) sgn v
//! ```
//!
//! k \[V\] > 0: more friction when slow; v_s \[m/s\]: where it has fallen to a third; d \[1\]: how sharply it falls. Measured
//! exponents are 0.5 to 2: Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994), 1083, section 2.1.

use super::definition::{Acting, Excitation, Moment, MotorEffect, MotorFacts, MotorParameter};

/// Friction falls with speed.
#[derive(Debug)]
pub struct Stribeck;

impl MotorEffect for Stribeck {
    fn facts(&self) -> MotorFacts<'_> {
        FACTS
    }

    fn act(&self, p: &[f64], moment: &Moment, acting: &mut Acting) {
        let ratio = (moment.speed_mps.0 / p[1]).abs();
        acting.add_friction_v(p[0] * (-ratio.powf(p[2])).exp());
    }

    fn starts(&self, excitation: &Excitation) -> Vec<Vec<f64>> {
        [0.06, 0.15, 0.35].map(|share| vec![0.0, share * excitation.speed_mps_max, 1.2]).into()
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "stribeck",
    name: "friction falls as a wheel begins to turn (Stribeck)",
    equation: "(kS + k exp(-|v / v_s|^d)) sgn v",
    parameters: &[
        MotorParameter::positive("k", "V", 0.1, 6.0),
        MotorParameter::shape("v_s", "m/s", 0.004, 1.0),
        MotorParameter::shape("d", "1", 0.5, 2.0),
    ],
    sign: "more friction when slow",
    shown_by: "creeping, and slow steps",
    remedy: "never creep: begin a motion with a step of k beyond kS",
};
