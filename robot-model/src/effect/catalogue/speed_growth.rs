//! The rolling radius grows with the speed.
//!
//! ```text
//! R_i -> R_i (1 + k v_i^2)
//! ```
//!
//! k \[s^2/m^2\] > 0: further at speed. v_i is the speed of the wheel's own rim, as its spin makes a
//! wheel grow.

use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// Wheels grow with speed.
#[derive(Debug)]
pub struct SpeedGrowth;

impl Effect for SpeedGrowth {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let travel = step.wheel_speed_mps.map(|v| p[0] * (v * v));
        Change { travel, ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "speed_growth",
    name: "wheel radius grows with speed",
    equation: "R_i (1 + k v_i^2)",
    parameters: &[Parameter::amplitude("k", "s^2/m^2", 0.2).possible(-1.0, 1.0)],
    signature: "a distance error at high speeds only",
    shown_by: "straight runs at several speeds",
    compensation: "add this term to the odometry",
    ..Facts::DEFAULT
};
