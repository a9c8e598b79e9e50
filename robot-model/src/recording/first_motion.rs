//! Which poses were measured before the robot rolled?
//!
//! Before its first motion a robot stands as it was put there: nobody knows on which flank each gear's play lies, nor
//! where the caster points. The first millimetres settle both and turn the robot a little, by an amount that belongs to
//! the standing and not to the robot. A track is therefore judged from the first pose after them. A run of which only
//! some poses were measured, as its two ends, needs the one at its start.

use crate::recording::motion::Motion;
use crate::recording::run::PoseMeasurement;

/// The rims have rolled so far when plays and caster have settled \[m\]: half a degree of play on a wheel of 60 mm is
/// 0.3 mm, and the encoder check before a drive rolls a millimetre or two.
const SETTLED_M: f64 = 0.005;
/// A track with fewer poses than this keeps all of them.
const POSES_MIN: usize = 20;

/// Leaves out the poses that were measured before the robot rolled, if a track remains.
pub(super) fn leave_out_standing(motion: &Motion, poses: &mut Vec<PoseMeasurement>) {
    let mut rolled_m = 0.0;
    let settled = motion.steps.iter().find(|step| {
        rolled_m += step.rolled_m();
        rolled_m > SETTLED_M
    });
    let Some(step) = settled else { return };
    let from_s = motion.start_s + step.t_s;
    let standing = poses.iter().take_while(|pose| pose.t_s < from_s).count();
    if poses.len() - standing >= POSES_MIN {
        poses.drain(..standing);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::nominal_run::{Piece, Sampling, nominal_run};
    use crate::tests::synthetic::ROBOT;

    #[test]
    fn a_track_begins_after_the_first_millimetres_and_a_run_of_two_poses_keeps_both() {
        for piece in [
            Piece::Straight { travel_m: 0.5, speed_mps: 0.2 },
            Piece::Spin { turn_rad: -2.0, speed_mps: 0.2 },
        ] {
            let pieces = [Piece::Rest { duration_s: 1.0 }, piece];
            let run = nominal_run(&ROBOT, "run", &pieces, &Sampling::USUAL);
            let motion = Motion::new(&ROBOT, &run, None);
            let mut poses = run.measured_poses.clone();
            leave_out_standing(&motion, &mut poses);
            // At 0.3 m/s^2 five millimetres take 0.18 s.
            assert!((1.15..1.3).contains(&poses[0].t_s), "{}", poses[0].t_s);
            assert_eq!(poses.last(), run.measured_poses.last());
            let ends = [run.measured_poses[0], run.measured_poses[run.measured_poses.len() - 1]];
            let mut kept = ends.to_vec();
            leave_out_standing(&motion, &mut kept);
            assert_eq!(kept, ends);
        }
    }
}
