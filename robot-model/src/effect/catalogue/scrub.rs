//! The effective track width grows with the sharpness of the turn, as the tyres scrub.
//!
//! ```text
//! b -> b (1 + k chi),  chi = |omega| b / (2 |v| + |omega| b)
//! ```
//!
//! chi is 0 on a straight, 1 in a spin; at rest, where it is neither, it is taken as 0.
//! k > 0: the tighter the turn, the less the robot turns of what its encoders say.

use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// Turning on the spot drags the tyres sideways.
#[derive(Debug)]
pub struct Scrub;

impl Effect for Scrub {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let chi = step.turn_sharpness();
        Change { turning: (p[0] * chi + 1.0).recip() - 1.0, ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "scrub",
    name: "tyre scrub in tight turns",
    equation: "b (1 + k chi), chi = |omega| b / (2 |v| + |omega| b)",
    parameters: &[Parameter::amplitude("k", "1", 0.9).usually(0.12).possible(-1.0, f64::INFINITY)],
    signature: "spins and wide arcs disagree on the track width",
    shown_by: "spins, and arcs of two radii",
    compensation: "make the track width depend on the curvature",
    ..Facts::DEFAULT
};
