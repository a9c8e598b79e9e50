//! Something drags on one side, whichever way the robot goes.
//!
//! ```text
//! dtheta = c |ds|
//! ```
//!
//! c \[rad/m\] > 0: to the left, forwards and backwards.

use crate::effect::definition::{Change, Effect, Facts, FirmwareTerm, Memory, Parameter};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// Something pulls the robot to one side.
#[derive(Debug)]
pub struct HeadingPull;

impl Effect for HeadingPull {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        Change { turn_rad: p[0] * step.travel_m().abs(), ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "heading_pull",
    name: "pull to one side",
    equation: "dtheta = c |ds|",
    parameters: &[Parameter::amplitude("c", "rad/m", 0.5).usually(0.05)],
    signature: "straight runs turn to the same side forwards and backwards",
    shown_by: "an out-and-back straight run",
    compensation: "steer against it, by the firmware's geometry.heading_pull_rad_per_m",
    compensated_by: Some(FirmwareTerm::HeadingPull),
    ..Facts::DEFAULT
};
