//! The pile of a carpet carries the robot in one direction of the world.
//!
//! ```text
//! drift = (d_x, d_y) |ds|
//! ```
//!
//! d: metres for each metre travelled, in the fixed frame; no turn.

use crate::effect::definition::{Change, Effect, Facts, Group, Memory, Parameter};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// The pile of a carpet carries the robot along.
#[derive(Debug)]
pub struct CarpetDrift;

impl Effect for CarpetDrift {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let path_m = step.travel_m().abs();
        Change { drift_m: [p[0] * path_m, p[1] * path_m], ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "carpet_drift",
    name: "drift on a carpet",
    equation: "world drift (d_x, d_y) |ds|",
    parameters: &[
        Parameter::amplitude("d_x", "1", 0.3).usually(0.05),
        Parameter::amplitude("d_y", "1", 0.3).usually(0.05),
    ],
    signature: "drift that depends on the heading, while the heading itself is right",
    shown_by: "straight runs in four headings",
    compensation: "add a drift vector to the odometry",
    group: Group::Floor,
    ..Facts::DEFAULT
};
