//! The tyres slip sideways in proportion to the side force in a turn.
//!
//! ```text
//! dn = -k v omega dt
//! ```
//!
//! k \[s\] > 0: to the outside of the turn.

use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// Side forces in turns push the robot outwards.
#[derive(Debug)]
pub struct SideSlip;

impl Effect for SideSlip {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        Change { sideways_m: p[0] * (-step.speed_mps() * step.turn_rad()), ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "side_slip",
    name: "side slip in arcs",
    equation: "dn = -k v omega dt",
    parameters: &[Parameter::amplitude("k", "s", 1.0).usually(0.15)],
    signature: "a sideways error in arcs that grows with the speed",
    shown_by: "arcs at two speeds, in both directions",
    compensation: "add this term to the odometry",
    ..Facts::DEFAULT
};
