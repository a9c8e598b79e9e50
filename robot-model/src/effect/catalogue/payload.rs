//! A load flattens the tyres.
//!
//! ```text
//! R -> R (1 - k m)
//! ```
//!
//! k \[1/kg\] > 0: smaller under load m.

use crate::effect::definition::{Change, Effect, Facts, Memory, Need, Parameter};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// A load flattens the tyres.
#[derive(Debug)]
pub struct Payload;

impl Effect for Payload {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        Change { travel: WheelPair::both(p[0] * -step.payload_kg), ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "payload",
    name: "tyres flattened by the load",
    equation: "R (1 - k m)",
    parameters: &[Parameter::amplitude("k", "1/kg", 0.1).usually(0.01)],
    signature: "distances that differ between loads",
    shown_by: "straight runs with and without a load",
    compensation: "correct the radius by a table over the load",
    needs: &[Need::Load],
    ..Facts::DEFAULT
};
