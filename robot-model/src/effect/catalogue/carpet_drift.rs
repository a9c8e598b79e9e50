//! The pile of a carpet carries the robot in one direction of the world.
//!
//! ```text
//! drift = (d_x, d_y) (|ds_L| + |ds_R|)/2
//! ```
//!
//! d: metres for each metre that the wheels roll, in the fixed frame; no turn. In a spin as well, where the middle goes nowhere.

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
        let rolled_m = step.rolled_m();
        Change { drift_m: [p[0] * rolled_m, p[1] * rolled_m], ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "carpet_drift",
    name: "drift on a carpet",
    equation: "world drift (d_x, d_y) (|ds_L| + |ds_R|)/2",
    parameters: &[
        Parameter::amplitude("d_x", "1", 0.2).usually(0.05),
        Parameter::amplitude("d_y", "1", 0.2).usually(0.05),
    ],
    signature: "drift that depends on the heading, while the heading itself is right",
    shown_by: "straight runs in four headings",
    compensation: "add a drift vector to the odometry",
    group: Group::Floor,
    ..Facts::DEFAULT
};
