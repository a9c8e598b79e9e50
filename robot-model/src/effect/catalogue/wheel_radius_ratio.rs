//! The wheels differ in radius.
//!
//! ```text
//! R_L = R (1 - rho/2),  R_R = R (1 + rho/2),  W_T = (1 + rho/2) / (1 - rho/2)
//! ```
//!
//! rho > 0: the right wheel is the larger one, so that equal turns curve to the left.

use crate::effect::definition::{Change, Effect, Facts, FirmwareTerm, Group, Memory, Parameter};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// One wheel is larger than the other.
#[derive(Debug)]
pub struct WheelRadiusRatio;

impl Effect for WheelRadiusRatio {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], _step: &Step, _memory: &mut Memory) -> Change {
        Change { travel: WheelPair::new(p[0] * -0.5, p[0] * 0.5), ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "wheel_radius_ratio",
    name: "unequal wheel radii",
    equation: "R_L = R (1 - rho/2), R_R = R (1 + rho/2)",
    parameters: &[Parameter::amplitude("rho", "1", 0.5).usually(0.03).possible(-2.0, 2.0)],
    signature: "straight runs curve, in reverse to the other side",
    shown_by: "an out-and-back straight run",
    compensation: "correct the right wheel's distance per count, Q_R",
    group: Group::Geometry,
    compensated_by: Some(FirmwareTerm::WheelWeight),
    ..Facts::DEFAULT
};
