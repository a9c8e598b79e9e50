//! The rolling radius grows with the speed.
//!
//! ```text
//! R -> R (1 + k v^2)
//! ```
//!
//! k \[s^2/m^2\] > 0: further at speed.

use super::{ActsOn, Change, Effect, Facts, Memory, Parameter};
use crate::jet::{Jet, PARAMETERS_MAX};
use crate::motion::Step;
use crate::sides::Sides;

/// Wheels grow with speed.
#[derive(Debug)]
pub struct SpeedGrowth;

impl Effect for SpeedGrowth {
    fn facts(&self) -> &'static Facts {
        &FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let v = step.speed_mps();
        Change { travel: Sides::both(p[0] * (v * v)), ..Change::NONE }
    }
}

static FACTS: Facts = Facts {
    id: "speed_growth",
    name: "wheel radius grows with speed",
    equation: "R (1 + k v^2)",
    parameters: &[Parameter::amplitude("k", "s^2/m^2", 0.2)],
    acts_on: ActsOn::Motion,
    signature: "an error along the path at high speeds only",
    shown_by: "straight runs at several speeds",
    compensation: "a term in the odometry",
};
