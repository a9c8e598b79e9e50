//! The measured point is not the middle between the wheels.
//!
//! ```text
//! z = pose + (l_x, l_y) on the body
//! ```
//!
//! l_x \[m\] ahead, l_y \[m\] to the left.

use crate::effect::definition::{ActsOn, Effect, Facts, Parameter, View};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};

/// The marker does not sit in the middle between the wheels.
#[derive(Debug)]
pub struct MarkerOffset;

impl Effect for MarkerOffset {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn observe(&self, p: &[Jet; PARAMETERS_MAX]) -> View {
        View { offset_m: [p[0], p[1]], ..View::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "marker_offset",
    name: "marker offset",
    equation: "the measured point sits at (l_x, l_y) on the body",
    parameters: &[
        Parameter::amplitude("l_x", "m", 2.0).usually(0.3),
        Parameter::amplitude("l_y", "m", 2.0).usually(0.3),
    ],
    acts_on: ActsOn::Measurement,
    signature: "a position error in proportion to the rotation",
    shown_by: "spins",
    compensation: "enter the marker's position in the tracking system",
    ..Facts::DEFAULT
};
