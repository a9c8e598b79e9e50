//! A voltage acts later than it was applied.
//!
//! ```text
//! V(t) -> V(t - tau)
//! ```
//!
//! tau \[s\] > 0: later. Counts that come late look the same.

use super::definition::{MotorEffect, MotorFacts, MotorParameter};

/// The voltage acts late.
#[derive(Debug)]
pub struct TransportDelay;

impl MotorEffect for TransportDelay {
    fn facts(&self) -> MotorFacts<'_> {
        FACTS
    }

    fn delay_s(&self, p: &[f64]) -> f64 {
        p[0]
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "transport_delay",
    name: "the voltage acts late",
    equation: "V(t - tau)",
    parameters: &[MotorParameter::positive("tau", "s", 0.003, 0.06)],
    sign: "later",
    shown_by: "steps and reversals, recorded every 5 ms",
    remedy: "a driver without an input filter; lower gains tolerate the rest",
};
