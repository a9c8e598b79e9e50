//! The result of a measured drive, alone and together with the way back.

use robot_model::calibration::out_and_back::OutAndBackError;
use robot_model::calibration::{Deviation, Experiment, Leg, OutAndBack, Shared, WheelWeight};
use robot_model::kinematics::Geometry;

use crate::picture::RunReport;

/// The result of one drive.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// W_T, if the deviation comes from the radii alone.
    pub wheel_weight: WheelWeight,
    /// The drive, for the picture.
    pub run: RunReport,
    /// This drive as one way of an out-and-back.
    pub way: OneWay,
}

/// A drive as one way of an out-and-back.
#[derive(Clone, Copy, Debug)]
pub enum OneWay {
    /// From a track, without its first decimetres, in which a caster swings round and turns the
    /// robot.
    Track(Leg),
    /// From a reading by a person or the simulator's ruler, which includes these decimetres.
    Reading(Experiment),
}

impl Measurement {
    /// The reading, unless a track was measured.
    pub(super) fn deviation(&self) -> Option<Deviation> {
        match &self.way {
            OneWay::Track(_) => None,
            OneWay::Reading(experiment) => Some(experiment.deviation),
        }
    }

    /// Separates radius from pull, using this drive and `back`, the same drive backwards from its
    /// end.
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
