//! An encoder's disk is mounted off its centre: the error repeats with each turn of the encoder.
//!
//! ```text
//! R_i -> R_i (1 + c_i cos (gear_reduction phi_i) + s_i sin (gear_reduction phi_i))
//! ```
//!
//! c_i > 0: at angle 0 of the encoder the wheel turns further than is read; s_i > 0: a quarter turn of the
//! encoder later. With the marks' centre off the shaft by e, at an angle alpha from the reading head, h
//! away, at phi_i = 0: c_i = -e/h cos alpha, s_i = e/h sin alpha.
//! The angle is that of the encoder's count, so the run files must not reset it between runs.

use super::wheel_eccentricity::{ONCE_PER_TURN, once_per_turn};
use crate::effect::definition::{Change, Effect, Facts, Memory, Need};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// An encoder is mounted off its centre.
#[derive(Debug)]
pub struct EncoderEccentricity;

impl Effect for EncoderEccentricity {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        once_per_turn(p, step, step.gear_reduction)
    }
}

static FACTS: Facts<'static> = Facts {
    id: "encoder_eccentricity",
    name: "eccentric encoders",
    equation: "R_i (1 + c_i cos (gear_reduction phi_i) + s_i sin (gear_reduction phi_i))",
    parameters: &ONCE_PER_TURN,
    signature: "a ripple once per encoder revolution",
    shown_by: "a slow run, sampled several times per encoder revolution",
    compensation: "correct the counts by a table over the encoder's angle",
    needs: &[Need::ContinuousCounts],
    ..Facts::DEFAULT
};
