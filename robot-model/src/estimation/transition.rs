//! Where does one increment lead the pose, and with which derivatives? And which measurements fall within a run?

use crate::effect::composition::Increment;
use crate::kinematics::pose::Pose;
use crate::numeric::angle::{sinc, sinc_slope};
use crate::recording::motion::{Motion, Step};
use crate::recording::run::PoseMeasurement;

/// A move by a share of an increment: where it leads, and its derivatives by the start's heading
/// and by the increment.
pub(crate) struct Transition {
    pub pose: Pose,
    /// Derivative of x and y by the heading.
    pub by_heading: [f64; 2],
    /// Derivative of x and y by the turn.
    pub by_turn: [f64; 2],
    /// Derivative of the turn by the start's heading, which is in none of the above.
    pub turn_by_heading: f64,
    /// sinc(turn/2) times the unit vector ahead: the derivative by the travel.
    pub ahead: [f64; 2],
}

impl Transition {
    pub fn new(pose: Pose, increment: &Increment, share: f64) -> Self {
        let turn = increment.turn_rad * share;
        let (travel_m, sideways_m) = (increment.travel_m * share, increment.sideways_m * share);
        let half = turn / 2.0;
        let (sin, cos) = (pose.heading_rad + half).sin_cos();
        let shorter = sinc(half);
        let slope = sinc_slope(half, shorter);
        let chord = [travel_m * cos - sideways_m * sin, travel_m * sin + sideways_m * cos];
        let moved = [shorter * chord[0], shorter * chord[1]];
        Self {
            pose: Pose {
                x_m: pose.x_m + moved[0] + increment.drift_m[0] * share,
                y_m: pose.y_m + moved[1] + increment.drift_m[1] * share,
                heading_rad: pose.heading_rad + turn,
            },
            by_heading: [-moved[1], moved[0]],
            turn_by_heading: increment.turn_by_heading * share,
            by_turn: [0.5 * (slope * chord[0] - moved[1]), 0.5 * (slope * chord[1] + moved[0])],
            ahead: [shorter * cos, shorter * sin],
        }
    }
}

/// The poses measured while the encoders were recorded. Where none of them shows the robot as it stood at the beginning or
/// at the end, so does a pose measured a moment before or after. They do not depend on a model's delay, as models are
/// compared on the same measurements.
pub(crate) fn within<'s>(
    motion: &Motion,
    measurements: &'s [PoseMeasurement],
) -> impl Iterator<Item = &'s PoseMeasurement> {
    let start_s = motion.start_s;
    let end_s = start_s + motion.steps.iter().map(|step| step.dt_s).sum::<f64>();
    let middle_s = (start_s + end_s) / 2.0;
    let from_to_s = |from_s: f64, to_s: f64| from_s - TIME_ROUNDING_S..=to_s + TIME_ROUNDING_S;
    let is_seen = |from_s: f64, to_s: f64| {
        let during = from_to_s(from_s, to_s);
        measurements.iter().any(|pose| during.contains(&pose.t_s))
    };
    let outside_s = |seen: bool, stood_s: f64| if seen { 0.0 } else { stood_s };
    let (first_s, last_s) = (stood_s(motion.steps.iter()), stood_s(motion.steps.iter().rev()));
    let before_s = outside_s(is_seen(start_s, (start_s + first_s).min(middle_s)), first_s);
    let after_s = outside_s(is_seen((end_s - last_s).max(middle_s), end_s), last_s);
    let during = from_to_s(start_s - before_s, end_s + after_s);
    measurements.iter().filter(move |pose| during.contains(&pose.t_s))
}

/// A robot whose rims move less than this stands \[m\].
const STANDS_M: f64 = 2e-4;

/// How long the robot stands in the first of these steps \[s\]. It is taken to stand as long before them, or after.
///
/// The last pose is often measured a moment after the last counts. Where only ends are measured, the run would be lost
/// without it.
fn stood_s<'s>(steps: impl Iterator<Item = &'s Step>) -> f64 {
    let (mut stood_s, mut rolled_m) = (0.0, 0.0);
    for step in steps {
        let wheels_m = step.wheel_travel_m().map(f64::abs);
        rolled_m += wheels_m.left.max(wheels_m.right);
        if rolled_m > STANDS_M {
            break;
        }
        stood_s += step.dt_s;
    }
    stood_s
}

/// Times that differ by less are the same \[s\]: sums of steps are rounded.
pub(crate) const TIME_ROUNDING_S: f64 = 1e-7;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::composition::{PlacedTerm, Terms};
    use crate::estimation::campaign_equations::CampaignEquations;
    use crate::estimation::errors::cross_validated;
    use crate::estimation::predict::open_loop;
    use crate::recording::campaign::Campaign;
    use crate::recording::nominal_run::Piece;
    use crate::recording::run::Recording;
    use crate::tests::synthetic::{NOISE, ROBOT, campaign, end_poses_only, part_of_plan, term};

    /// Runs of which only the first and the last pose are measured, the last one so late after the last counts \[s\].
    fn ends(late_s: f64) -> Campaign {
        let truth = [term("wheel_radius_ratio", &[0.005])];
        let mut plan = part_of_plan(&["arc", "spin"]);
        plan.iter_mut().for_each(|run| run.2.push(Piece::Rest { duration_s: 0.3 }));
        let mut campaign = end_poses_only(campaign(&plan, &truth, 3));
        for run in &mut campaign.runs {
            run.measured_poses[1].t_s = run.wheels[run.wheels.len() - 1].t_s + late_s;
        }
        campaign
    }

    /// Cross-validated errors with a ratio of the radii that is fitted.
    fn errors(campaign: &Campaign) -> [f64; 3] {
        let prepared = campaign.prepare().unwrap();
        let terms = PlacedTerm::place(&[term("wheel_radius_ratio", &[0.0])]);
        let equations = CampaignEquations::gather(&prepared, &terms, &NOISE);
        let errors = cross_validated(&prepared, (&equations, &terms), &[0], &NOISE);
        [errors.position_rms_m, errors.heading_rms_rad, errors.chi]
    }

    #[test]
    fn a_pose_a_moment_after_the_last_counts_is_where_the_robot_stands() {
        let (at_once, late) = (ends(0.0), ends(0.007));
        let run = &late.runs[0];
        let motion = Motion::new(&ROBOT, run, None);
        assert_eq!(within(&motion, &run.measured_poses).count(), 2);
        let predicted = |run: &Recording| {
            let motion = Motion::new(&ROBOT, run, None);
            open_loop(&motion, &run.measured_poses, Terms::Fixed(&[])).predicted
        };
        assert_eq!(predicted(&at_once.runs[0]), predicted(run));
        // No run is lost, and each tells as much.
        for (one, other) in errors(&at_once).iter().zip(errors(&late)) {
            assert!((one / other - 1.0).abs() < 1e-6, "{one}, {other}");
        }
    }

    #[test]
    fn a_pose_after_the_last_counts_adds_nothing_where_the_end_was_measured() {
        let mut run = ends(0.0).runs.swap_remove(0);
        let motion = Motion::new(&ROBOT, &run, None);
        let last = run.measured_poses[1];
        run.measured_poses.push(PoseMeasurement { t_s: last.t_s + 0.007, ..last });
        assert_eq!(within(&motion, &run.measured_poses).count(), 2);
    }

    #[test]
    fn a_pose_of_a_robot_that_may_have_gone_on_is_not_used() {
        // It stood for a few tenths of a second, and was measured ten seconds later.
        let late = ends(10.0);
        let run = &late.runs[0];
        let motion = Motion::new(&ROBOT, run, None);
        assert_eq!(within(&motion, &run.measured_poses).count(), 1);
        // The counts end while it moves.
        let mut moving = ends(0.007).runs.swap_remove(0);
        let half = moving.wheels.len() / 2;
        moving.wheels.truncate(half);
        moving.measured_poses[1].t_s = moving.wheels[half - 1].t_s + 0.007;
        let motion = Motion::new(&ROBOT, &moving, None);
        assert_eq!(within(&motion, &moving.measured_poses).count(), 1);
        moving.measured_poses[1].t_s -= 0.007;
        assert_eq!(within(&motion, &moving.measured_poses).count(), 2);
    }
}
