//! The motor holds at some angles more than at others: magnets and teeth of the motor, teeth of the gear.
//!
//! ```text
//! a_i cos(n phi_i) + b_i sin(n phi_i)          i: left, right; phi: angle of the wheel
//! ```
//!
//! a, b \[V\]; n: waves per turn of the wheel. The angle is that of the counter, so it must count on from run to run.

use core::f64::consts::TAU;

use super::definition::{Acting, Excitation, Moment, MotorEffect, MotorFacts, MotorParameter};

/// A wave needs so many counts to show.
const COUNTS_PER_WAVE: f64 = 6.0;

/// Torque that depends on the angle.
#[derive(Debug)]
pub struct Cogging;

impl MotorEffect for Cogging {
    fn facts(&self) -> MotorFacts<'_> {
        FACTS
    }

    fn act(&self, p: &[f64], moment: &Moment, acting: &mut Acting) {
        let (a, b) = if moment.side > 0.0 { (p[0], p[1]) } else { (p[2], p[3]) };
        let (sin, cos) = (TAU * p[4] * moment.turns).sin_cos();
        acting.volts -= a * cos + b * sin;
    }

    /// Waves per turn of the encoder and per turn of the wheel, as far as the counts can show them.
    fn starts(&self, excitation: &Excitation) -> Vec<Vec<f64>> {
        let most = excitation.counts_per_wheel_turn / COUNTS_PER_WAVE;
        let gear = excitation.gear_reduction;
        let of_encoder = (1..=4).map(|n| gear * f64::from(n));
        let of_wheel = (1..=24).map(f64::from);
        let mut waves: Vec<f64> = of_encoder.chain(of_wheel).filter(|n| *n <= most).collect();
        waves.sort_by(f64::total_cmp);
        waves.dedup();
        waves.into_iter().map(|n| vec![0.0, 0.0, 0.0, 0.0, n]).collect()
    }
}

static FACTS: MotorFacts = MotorFacts {
    id: "cogging",
    name: "torque depends on the angle (cogging, teeth)",
    equation: "a_i cos(n phi_i) + b_i sin(n phi_i)",
    parameters: &[
        MotorParameter::amplitude("a_left", "V", 0.05, 3.0),
        MotorParameter::amplitude("b_left", "V", 0.05, 3.0),
        MotorParameter::amplitude("a_right", "V", 0.05, 3.0),
        MotorParameter::amplitude("b_right", "V", 0.05, 3.0),
        MotorParameter::shape("n", "1", 0.5, 1e4),
    ],
    sign: "holds where the wave is high",
    shown_by: "creeping over several turns",
    remedy: "a table of voltages by angle",
};
