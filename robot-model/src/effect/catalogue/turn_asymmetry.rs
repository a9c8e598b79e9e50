//! Turns to the left and to the right come out differently.
//!
//! ```text
//! dtheta -> dtheta (1 + k sgn omega)
//! ```
//!
//! k > 0: left turns come out larger, right ones smaller.

use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// Left turns and right turns differ.
#[derive(Debug)]
pub struct TurnAsymmetry;

impl Effect for TurnAsymmetry {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        Change { turning: p[0] * step.turn_rate_rad_s().signum(), ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "turn_asymmetry",
    name: "left and right turns differ",
    equation: "dtheta (1 + k sgn omega)",
    parameters: &[Parameter::amplitude("k", "1", 0.3).usually(0.05).possible(-1.0, 1.0)],
    signature: "spins to the left and to the right disagree on the track width",
    shown_by: "spins to both sides",
    compensation: "use one track width for each direction of turn",
    ..Facts::DEFAULT
};
