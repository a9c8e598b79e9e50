//! The measured pose is that of a moment ago.
//!
//! ```text
//! z(t) = pose(t - tau)
//! ```
//!
//! tau \[s\] > 0: late; < 0: the encoders are late.

use crate::effect::definition::{ActsOn, Effect, Facts, Parameter, View};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};

/// The measured pose is old.
#[derive(Debug)]
pub struct MeasurementDelay;

impl Effect for MeasurementDelay {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn observe(&self, p: &[Jet; PARAMETERS_MAX]) -> View {
        View { delay_s: p[0], ..View::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "measurement_delay",
    name: "delayed pose measurements",
    equation: "z(t) = pose(t - tau)",
    parameters: &[Parameter::amplitude("tau", "s", 0.3)],
    acts_on: ActsOn::Measurement,
    signature: "a position error in proportion to the velocity, opposite when driving backwards",
    shown_by: "a run that stops and starts",
    compensation: "stamp each pose with the time of its measurement",
    ..Facts::DEFAULT
};
