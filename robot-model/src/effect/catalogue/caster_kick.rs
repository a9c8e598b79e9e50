//! After a reversal of travel the caster swings round and pushes the robot's end aside.
//!
//! ```text
//! dtheta = A exp(-s/l) ds/l,  s = path since the reversal
//! ```
//!
//! A \[rad\] is the whole turn of one swing, left positive, of a reversal to forwards; l \[m\] its length.
//! The step's integral is exact: A (exp(-s0/l) - exp(-s1/l)), with the sign of ds.

use crate::effect::definition::{Change, Effect, Facts, Memory, Parameter};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::excitation::Excitation;
use crate::recording::motion::Step;

/// The caster swings round after a reversal.
#[derive(Debug)]
pub struct CasterKick;

impl Effect for CasterKick {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let Some(since_m) = step.since_reversal_m else {
            return Change::NONE;
        };
        let ds_m = step.travel_m();
        let decay = |path_m: f64| ((-p[1].recip()) * path_m).exp();
        let share = decay(since_m) - decay(since_m + ds_m.abs());
        Change { turn_rad: p[0] * share * ds_m.signum(), ..Change::NONE }
    }

    fn starts(&self, _excitation: &Excitation) -> Vec<Vec<f64>> {
        [0.03, 0.06, 0.12].map(|length_m| vec![0.0, length_m]).into()
    }
}

static FACTS: Facts<'static> = Facts {
    id: "caster_kick",
    name: "caster kick after reversing",
    equation: "dtheta = A exp(-s/l) ds/l after a reversal of travel",
    parameters: &[
        Parameter::amplitude("angle", "rad", 0.3),
        Parameter::shape("length", "m", 0.01, 0.4),
    ],
    signature: "a turn in the first centimetres after a reversal",
    shown_by: "an out-and-back run",
    compensation: "drive a short run-in after each reversal",
    ..Facts::DEFAULT
};
