//! Play between the motor, whose turn is counted, and its wheel.
//!
//! ```text
//! |x_motor - x_wheel| <= beta / 2; between the flanks the motor has the share r of the inertia, and the wheel rolls freely
//! ```
//!
//! beta \[m\] > 0, as travel of the wheel; r \[1\]: share of the inertia that is the motor's.

use super::definition::{Excitation, MotorEffect, MotorFacts, MotorParameter, Play};

/// Play in the gear.
#[derive(Debug)]
pub struct Backlash;

impl MotorEffect for Backlash {
    fn facts(&self) -> MotorFacts<'_> {
        FACTS
    }

    fn play(&self, p: &[f64]) -> Option<Play> {
        (p[0] > 0.0).then_some(Play { travel_m: p[0], motor_share: p[1] })
    }

    fn starts(&self, _excitation: &Excitation) -> Vec<Vec<f64>> {
        vec![vec![0.0, 0.3]]
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "backlash",
    name: "play between motor and wheel",
    equation: "|x_motor - x_wheel| <= beta / 2",
    parameters: &[
        MotorParameter::positive("beta", "m", 5e-4, 0.03),
        MotorParameter::shape("r", "1", 0.05, 0.9),
    ],
    sign: "wider",
    shown_by: "reversals, and rolling out",
    remedy: "a tighter gear; lower integral gain",
};
