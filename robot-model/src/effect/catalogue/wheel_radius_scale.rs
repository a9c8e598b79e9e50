//! Both wheels differ from the nominal radius alike.
//!
//! ```text
//! ds_i -> ds_i (1 + s)
//! ```
//!
//! s > 0: the robot goes further than its encoders say.

use crate::effect::definition::{Change, Effect, Facts, FirmwareTerm, Group, Memory, Parameter};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// Both wheels are larger than their data sheet says.
#[derive(Debug)]
pub struct WheelRadiusScale;

impl Effect for WheelRadiusScale {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], _step: &Step, _memory: &mut Memory) -> Change {
        Change { travel: WheelPair::both(p[0]), ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "wheel_radius_scale",
    name: "wrong mean wheel radius",
    equation: "ds_i (1 + s)",
    parameters: &[Parameter::amplitude("s", "1", 0.5).usually(0.03).possible(-1.0, f64::INFINITY)],
    signature: "a distance error in proportion to the distance",
    shown_by: "a straight run measured with a tape",
    compensation: "correct both distances per count, Q",
    group: Group::Geometry,
    compensated_by: Some(FirmwareTerm::MeanRadius),
    ..Facts::DEFAULT
};
