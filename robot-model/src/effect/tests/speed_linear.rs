//! The rolling radius grows with the speed.
//!
//! ```text
//! ds_i -> ds_i (1 + k |v|)
//! ```
//!
//! v \[m/s\] is the speed of the robot's middle. k \[s/m\] > 0: further at speed.

use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// Wheels grow with speed.
#[derive(Debug)]
pub struct SpeedLinear;

impl Effect for SpeedLinear {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        Change { travel: WheelPair::both(p[0] * step.speed_mps().abs()), ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "speed_linear",
    name: "wheel radius grows with speed",
    equation: "ds_i (1 + k |v|)",
    parameters: &[Parameter::amplitude("k", "s/m", 0.1)],
    signature: "a distance error at high speeds only",
    shown_by: "straight runs at several speeds",
    compensation: "add this term to the odometry",
    ..Facts::DEFAULT
};
