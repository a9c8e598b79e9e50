//! In a fast turn the load shifts to the outer wheel and deforms it.
//!
//! ```text
//! domega = -k v^2 omega
//! ```
//!
//! k \[s^2/m^2\] > 0: the robot turns less the faster it goes.

use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// In fast turns the outer wheel carries more.
#[derive(Debug)]
pub struct TurnLoadTransfer;

impl Effect for TurnLoadTransfer {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let v = step.speed_mps();
        Change { turning: p[0] * (-v * v), ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "turn_load_transfer",
    name: "load transfer in fast turns",
    equation: "domega = -k v^2 omega",
    parameters: &[Parameter::amplitude("k", "s^2/m^2", 0.2)],
    signature: "a heading error in fast arcs",
    shown_by: "arcs of one radius at two speeds",
    compensation: "add this term to the odometry",
    ..Facts::DEFAULT
};
