//! The floor slopes: the robot creeps and turns towards one direction of the world.
//!
//! ```text
//! ds_w   = (|ds_L| + |ds_R|)/2
//! drift  = l (k_x, k_y) ds_w
//! dtheta = k sin(beta - theta) ds_w,  (k_x, k_y) = k (cos beta, sin beta)
//! ```
//!
//! k \[rad/m\] is the turn towards the direction beta for each metre that the wheels roll, l \[m\] the creep for each such
//! turn: d = k l is the creep for each metre. A tyre creeps as far as it rolls: in a spin as well.

use crate::effect::definition::{Change, Effect, Facts, Group, Memory, Parameter};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::excitation::Excitation;
use crate::recording::motion::Step;

/// The floor is not level.
#[derive(Debug)]
pub struct Slope;

impl Effect for Slope {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        let rolled_m = step.rolled_m();
        let (sin, cos) = step.heading_rad.sin_cos();
        Change {
            turn_rad: (p[1] * cos - p[0] * sin) * rolled_m,
            turn_by_heading: -(p[1].value * sin + p[0].value * cos) * rolled_m,
            drift_m: [p[0] * p[2] * rolled_m, p[1] * p[2] * rolled_m],
            ..Change::NONE
        }
    }

    fn starts(&self, _excitation: &Excitation) -> Vec<Vec<f64>> {
        [0.0, -0.5, 0.5].map(|creep_m| vec![0.0, 0.0, creep_m]).into()
    }
}

static FACTS: Facts<'static> = Facts {
    id: "slope",
    name: "sloping floor",
    equation: "creep d ds_w towards beta, dtheta = k sin(beta - theta) ds_w, ds_w = (|ds_L| + |ds_R|)/2",
    parameters: &[
        Parameter::amplitude("k_x", "rad/m", 0.5).usually(0.05),
        Parameter::amplitude("k_y", "rad/m", 0.5).usually(0.05),
        Parameter::shape("l", "m", -2.0, 2.0),
    ],
    signature: "drift and turn that depend on the heading",
    shown_by: "straight runs in four headings",
    compensation: "level the floor, or use an IMU",
    group: Group::Floor,
    ..Facts::DEFAULT
};
