//! What a drive says once it is measured, alone and together with the way back.

use robot_model::calibration::out_and_back::OutAndBackError;
use robot_model::calibration::{Deviation, Experiment, Leg, OutAndBack, Shared, WheelWeight};
use robot_model::kinematics::Geometry;

use crate::picture::RunReport;

/// What a drive says.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// W_T, if the deviation is the radius alone.
    pub wheel_weight: WheelWeight,
    /// The drive, for the picture.
    pub run: RunReport,
    /// What this drive is good for as a way of an out-and-back.
    pub way: OneWay,
}

/// A drive as one way of an out-and-back.
#[derive(Clone, Copy, Debug)]
pub enum OneWay {
    /// From a track, without its first decimetres, in which a caster swings round and kicks.
    Track(Leg),
    /// From what a person or the simulator's ruler read, which cannot leave them out.
    Reading(Experiment),
}

impl Measurement {
    /// What was read, unless it was a track.
    pub(super) fn deviation(&self) -> Option<Deviation> {
        match &self.way {
            OneWay::Track(_) => None,
            OneWay::Reading(experiment) => Some(experiment.deviation),
        }
    }

    /// Separates radius from pull by this drive and `back`, the same one backwards from where it ended.
    pub(super) fn and_back(
        &self,
        back: &Measurement,
        geometry: &Geometry,
    ) -> std::result::Result<OutAndBack, OutAndBackError> {
        match (&self.way, &back.way) {
            (OneWay::Track(out), OneWay::Track(back)) => {
                OutAndBack::new(*out, *back, Shared::TRACKS, geometry)
            }
            (OneWay::Reading(out), OneWay::Reading(back)) => OutAndBack::by_readings(out, back),
            _ => Err(OutAndBackError::Mixed),
        }
    }
}
