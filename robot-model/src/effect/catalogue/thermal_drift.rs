//! The wheels grow slowly in the course of the campaign.
//!
//! ```text
//! R -> R (1 + k t),  t from the campaign's beginning
//! ```
//!
//! k \[1/s\] > 0: growing.

use crate::effect::definition::{Change, Effect, Facts, Memory, Need, Parameter};
use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::recording::motion::Step;

/// Wheels grow as they warm.
#[derive(Debug)]
pub struct ThermalDrift;

impl Effect for ThermalDrift {
    fn facts(&self) -> Facts<'_> {
        FACTS
    }

    fn act(&self, p: &[Jet; PARAMETERS_MAX], step: &Step, _memory: &mut Memory) -> Change {
        Change { travel: WheelPair::both(p[0] * step.clock_s), ..Change::NONE }
    }
}

static FACTS: Facts<'static> = Facts {
    id: "thermal_drift",
    name: "slow drift during the campaign",
    equation: "R (1 + k t)",
    parameters: &[Parameter::amplitude("k", "1/s", 1e-4)],
    signature: "a slow trend of the distance error from run to run",
    shown_by: "a repeat of the first run at the end",
    compensation: "calibrate again from time to time",
    needs: &[Need::StartTimes],
    ..Facts::DEFAULT
};
