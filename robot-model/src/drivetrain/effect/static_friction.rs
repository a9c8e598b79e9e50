//! A wheel at rest holds harder than one that turns.
//!
//! ```text
//! break-away at kS + s                         within 3 mm/s of rest
//! ```
//!
//! s \[V\] > 0: it takes more to break away than to keep turning.

use super::definition::{Acting, Moment, MotorEffect, MotorFacts, MotorParameter};

/// A wheel that is slower than about this rests \[m/s\].
const REST_MPS: f64 = 0.003;

/// Break-away above kS.
#[derive(Debug)]
pub struct StaticFriction;

impl MotorEffect for StaticFriction {
    fn facts(&self) -> MotorFacts<'_> {
        FACTS
    }

    fn act(&self, p: &[f64], moment: &Moment, acting: &mut Acting) {
        let ratio = moment.speed_mps.0 / REST_MPS;
        acting.add_friction_v(p[0] * (-ratio * ratio).exp());
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "static_friction",
    name: "a wheel at rest holds harder than one that turns",
    equation: "break-away at kS + s",
    parameters: &[MotorParameter::positive("s", "V", 0.1, 6.0)],
    sign: "it takes more to break away than to keep turning",
    shown_by: "slow ramps from rest, both ways",
    remedy: "begin a motion with a step of s beyond kS",
};
