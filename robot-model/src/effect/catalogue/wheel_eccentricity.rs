//! A wheel is not round, or not mounted at its centre.
//!
//! ```text
//! R_i -> R_i (1 + c_i cos phi_i + s_i sin phi_i)
//! ```
//!
//! c_i > 0: at angle 0 the axle stands high, and the wheel goes further than its mean; s_i > 0: a quarter
//! turn forward of that. With the axle off the centre by e, upwards at an angle alpha from straight ahead
//! at phi_i = 0: c_i = e/R sin alpha, s_i = -e/R cos alpha.
//! The angle is that of the encoder's count, so the run files must not reset it between runs.

use crate::effect::definition::{Change, Effect, Facts, Memory, Need, Parameter};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::angle::sinc;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// A wheel is mounted off its centre.
#[derive(Debug)]
pub struct WheelEccentricity;

impl Effect for WheelEccentricity {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        once_per_turn(p, step, 1.0)
    }
}

static FACTS: Facts<'static> = Facts {
    id: "wheel_eccentricity",
    name: "eccentric wheels",
    equation: "R_i (1 + c_i cos phi_i + s_i sin phi_i)",
    parameters: &ONCE_PER_TURN,
    signature: "a ripple once per wheel revolution",
    shown_by: "a slow run of several wheel revolutions",
    compensation: "correct the travel by a table over the wheel's angle",
    needs: &[Need::ContinuousCounts],
    ..Facts::DEFAULT
};

/// What [`once_per_turn`] takes.
pub(super) static ONCE_PER_TURN: [Parameter; 4] = [
    Parameter::amplitude("c_left", "1", 0.2).usually(0.05),
    Parameter::amplitude("s_left", "1", 0.2).usually(0.05),
    Parameter::amplitude("c_right", "1", 0.2).usually(0.05),
    Parameter::amplitude("s_right", "1", 0.2).usually(0.05),
];

/// A ripple of each wheel's travel, `often` times per turn of the wheel.
pub(super) fn once_per_turn(p: &[Jet; PARAMETERS_MAX], step: &Step, often: f64) -> Change {
    let turned = step.phi_rad.zip(step.dphi_rad).map(|(phi, dphi)| (phi * often, dphi * often));
    let travel = WheelPair::new(
        mean_over_step(p[0], p[1], turned.left.0, turned.left.1),
        mean_over_step(p[2], p[3], turned.right.0, turned.right.1),
    );
    Change { travel, ..Change::NONE }
}

/// The mean of c cos + s sin over the step: exact, so that a fast encoder does not alias.
fn mean_over_step(c: Jet, s: Jet, before_rad: f64, turned_rad: f64) -> Jet {
    let weight = sinc(turned_rad / 2.0);
    let middle_rad = before_rad + turned_rad / 2.0;
    c * (weight * middle_rad.cos()) + s * (weight * middle_rad.sin())
}
