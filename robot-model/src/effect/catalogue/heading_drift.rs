//! The measured heading drifts.
//!
//! ```text
//! heading measured = heading + r t,   t: time since the run began
//! ```
//!
//! r \[rad/s\], counter-clockwise positive: a heading from a yaw rate sensor whose bias was not taken off. What it drifted
//! before the run is the run's own zero.

use crate::effect::definition::{ActsOn, Effect, Facts, Parameter, View};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};

/// The measured heading drifts with time.
#[derive(Debug)]
pub struct HeadingDrift;

impl Effect for HeadingDrift {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn observe(&self, p: &[Jet; PARAMETERS_MAX]) -> View {
        View { heading_drift_rad_s: p[0], ..View::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "heading_drift",
    name: "drifting heading measurement",
    equation: "heading measured = heading + r t",
    parameters: &[Parameter::amplitude("r", "rad/s", 0.05).usually(0.005)],
    acts_on: ActsOn::Measurement,
    signature: "a heading error that grows with time, at rest too, while the positions are right",
    shown_by: "a run that stands still for half a minute",
    compensation: "take the yaw rate sensor's bias at rest off, or measure headings against the room",
    ..Facts::DEFAULT
};
