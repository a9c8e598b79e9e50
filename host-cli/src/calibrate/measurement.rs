//! The result of a measured drive, alone and together with the way back.

use robot_model::calibration::out_and_back::OutAndBackError;
use robot_model::calibration::{Deviation, Experiment, Leg, OutAndBack, Shared, WheelWeight};
use robot_model::kinematics::Geometry;

use crate::calibration_page::RunReport;
use robot_model::calibration::wheel_weight::SIGMAS_95;

/// How well the offset of a robot is known that stands still at both ends \[m\]: a heading of 2 mrad, of ten pictures,
/// over two metres.
const AT_REST_SIGMA_M: f64 = 0.0013;

/// The result of one drive.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// W_T, if the deviation comes from the radii alone.
    pub wheel_weight: WheelWeight,
    /// The drive, for the picture.
    pub run: RunReport,
    /// This drive as one way of an out-and-back.
    pub way: OneWay,
    /// How far beside the line the robot ended, left positive: as read, or by its poses at rest \[m\].
    pub offset_m: Option<f64>,
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
    /// Whether the robot drove straighter than in an earlier drive: it turned less and ended less far beside its line,
    /// both at most half as far, or not measurably. A pull \[rad/m\], clockwise positive, is in both drives; halves are
    /// those of what it leaves.
    pub(super) fn is_straighter_than(&self, before: &Self, pull_rad_per_m: f64) -> bool {
        let length_m = before.run.length_m();
        let is_nearer = |now_m: f64, then_m: f64| {
            let by_pull_m = -pull_rad_per_m * length_m * length_m / 2.0;
            let [now_less_m, then_less_m] = [now_m, then_m].map(|m| (m - by_pull_m).abs());
            let noise_m = SIGMAS_95 * self.run.end.lateral_offset_sigma_m.max(AT_REST_SIGMA_M);
            now_m.abs() < then_m.abs() && now_less_m <= (then_less_m / 2.0).max(noise_m)
        };
        let offsets_m = self.offset_m.zip(before.offset_m);
        offsets_m.is_none_or(|(now_m, then_m)| is_nearer(now_m, then_m))
            && self.run.is_straighter_than(&before.run, pull_rad_per_m * length_m)
    }

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
