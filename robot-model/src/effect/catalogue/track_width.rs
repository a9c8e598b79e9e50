//! The effective distance between the wheels differs from the nominal one.
//!
//! ```text
//! dtheta -> dtheta / (1 + delta),  b_true = b (1 + delta)
//! ```
//!
//! delta > 0: the robot turns less than its encoders say.

use crate::effect::definition::{Change, Effect, Facts, FirmwareTerm, Group, Memory, Parameter};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// The wheels stand further apart than nominal.
#[derive(Debug)]
pub struct TrackWidth;

impl Effect for TrackWidth {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], _step: &Step, _memory: &mut Memory) -> Change {
        Change { turning: (p[0] + 1.0).recip() - 1.0, ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "track_width",
    name: "wrong track width",
    equation: "dtheta / (1 + delta)",
    parameters: &[Parameter::amplitude("delta", "1", 0.5)
        .usually(0.12)
        .possible(-1.0, f64::INFINITY)],
    signature: "a heading error in proportion to the rotation, in both directions",
    shown_by: "spins to both sides",
    compensation: "correct the track width b",
    group: Group::Geometry,
    compensated_by: Some(FirmwareTerm::TrackWidth),
    ..Facts::DEFAULT
};
