//! Which single positions are elsewhere for one frame? And do the headings of all runs point a little away from where
//! the robot rolls?
//!
//! Both are things that a fit can live with; larger ones are hypotheses.

use crate::kinematics::pose::Pose;
use crate::numeric::angle::wrap;
use crate::recording::run::{PoseMeasurement, Recording, Robot};

use super::dead_reckoning::{FAR_M, Reckoned, at, median};

/// A position far from those before and after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spike {
    /// When \[s\].
    pub t_s: f64,
    /// How far off it is \[m\].
    pub off_m: f64,
}

/// A spike is off by at least this \[m\], and by this many times the median error between frames.
const SPIKE_M: f64 = 0.1;
const SPIKE_TIMES: f64 = 10.0;
/// Frames farther apart than this do not show that the one between them is wrong \[s\].
const SPIKE_S: f64 = 1.0;
/// Fewer rows do not show what is usual.
const STEPS_MIN: usize = 20;
/// A smaller angle between heading and travel may be a drift or a crooked axle \[rad\].
const TURNED_MIN_RAD: f64 = 0.0175;
/// With a larger one, headings count from another axis \[rad\].
const TURNED_MAX_RAD: f64 = 0.6;
/// It takes this many runs, nine of ten of which agree within this share.
const TURNED_RUNS_MIN: usize = 4;
const ALIKE: f64 = 0.25;
/// On a straight path the wheels turn the robot by no more than this \[rad\].
const STRAIGHT_RAD: f64 = 0.03;

/// The first position of a run that is elsewhere for one frame: an outlier, which a fit may well ignore.
pub fn spike(robot: &Robot, run: &Recording) -> Option<Spike> {
    let reckoned = Reckoned::of(robot, run);
    let poses = run.measured_poses.iter();
    let positions: Vec<(f64, [f64; 2])> =
        poses.filter_map(|pose| Some((pose.t_s, pose.position_m?))).collect();
    if positions.len() <= STEPS_MIN {
        return None;
    }
    let apart_m = |a: &(f64, [f64; 2]), b: &(f64, [f64; 2])| {
        let gap_m = (b.1[0] - a.1[0]).hypot(b.1[1] - a.1[1]);
        gap_m - reckoned.rolled(a.0, b.0).0
    };
    let usual_m =
        median(positions.windows(2).map(|pair| apart_m(&pair[0], &pair[1]).abs()).collect())?;
    let limit_m = SPIKE_M.max(SPIKE_TIMES * usual_m);
    let off = |three: &[(f64, [f64; 2])]| {
        let [before, row, after] = three else { return None };
        let off_m = apart_m(before, row).min(apart_m(row, after));
        let near = after.0 - before.0 < SPIKE_S && apart_m(before, after) < 0.5 * off_m;
        (off_m > limit_m && near).then_some(Spike { t_s: row.0, off_m })
    };
    positions.windows(3).find_map(off)
}

/// The angle from the direction of travel to the heading, if nearly all runs agree on it \[rad\].
pub fn heading_offset(robot: &Robot, runs: &[Recording]) -> Option<f64> {
    let each: Vec<f64> = runs.iter().filter_map(|run| median(turned(robot, run))).collect();
    let clear = |turned_rad: &f64| (TURNED_MIN_RAD..TURNED_MAX_RAD).contains(&turned_rad.abs());
    let turned_rad = median(each.clone()).filter(clear)?;
    let alike = each.iter().filter(|run| (*run - turned_rad).abs() < ALIKE * turned_rad.abs());
    (each.len() >= TURNED_RUNS_MIN && 10 * alike.count() >= 9 * each.len()).then_some(turned_rad)
}

/// On straight paths: the angle from the direction of travel, reversed if backwards, to the heading.
fn turned(robot: &Robot, run: &Recording) -> Vec<f64> {
    let reckoned = Reckoned::of(robot, run);
    let by_wheels = |pose: &PoseMeasurement| -> Pose { at(run, &reckoned.poses, pose.t_s) };
    let mut found = Vec::new();
    let mut start: Option<&PoseMeasurement> = None;
    for measurement in &run.measured_poses {
        let (Some([x_m, y_m]), Some(heading_rad)) =
            (measurement.position_m, measurement.heading_rad)
        else {
            continue;
        };
        let Some(from) = start else {
            start = Some(measurement);
            continue;
        };
        let to = by_wheels(measurement).seen_from(by_wheels(from));
        let path_m = reckoned.rolled(from.t_s, measurement.t_s).0;
        let straight = to.heading_rad.abs() < STRAIGHT_RAD && to.x_m.abs() > 0.98 * path_m;
        if !straight {
            start = Some(measurement);
        } else if let (true, Some([x0_m, y0_m])) = (path_m > FAR_M, from.position_m) {
            let (dx_m, dy_m) = ((x_m - x0_m) * to.x_m.signum(), (y_m - y0_m) * to.x_m.signum());
            let between_rad =
                heading_rad - wrap(heading_rad - from.heading_rad.unwrap_or(heading_rad)) / 2.0;
            found.push(wrap(between_rad - dy_m.atan2(dx_m)));
            start = Some(measurement);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::synthetic::{ALONE, ROBOT, campaign, full_plan, term};

    fn runs() -> Vec<Recording> {
        campaign(&full_plan(), &[], 3).runs
    }

    #[test]
    fn a_robot_that_is_merely_inaccurate_has_no_bad_rows_and_no_crooked_headings() {
        for (id, values) in ALONE {
            let runs = campaign(&full_plan(), &[term(id, values)], 3).runs;
            assert_eq!(runs.iter().find_map(|run| spike(&ROBOT, run)), None, "{id}");
            assert_eq!(heading_offset(&ROBOT, &runs), None, "{id}");
        }
    }

    #[test]
    fn one_position_that_is_elsewhere_is_found() {
        for run in runs().iter().filter(|run| run.measured_poses.len() > 2 * STEPS_MIN) {
            let mut wrong = run.clone();
            let middle = wrong.measured_poses.len() / 2;
            wrong.measured_poses[middle].position_m =
                run.measured_poses[middle].position_m.map(|[x, y]| [x, y + 0.5]);
            let found = spike(&ROBOT, &wrong);
            let at_s = run.measured_poses[middle].t_s;
            assert!(
                found.is_some_and(|spike| spike.t_s == at_s && spike.off_m > 0.4),
                "{}: {found:?}",
                run.name
            );
        }
    }

    #[test]
    fn headings_that_are_turned_in_all_runs_are_found_with_their_sign() {
        for turned_rad in [-0.3, -0.03, 0.03, 0.3] {
            let mut runs = runs();
            for pose in runs.iter_mut().flat_map(|run| &mut run.measured_poses) {
                pose.heading_rad = pose.heading_rad.map(|rad| rad + turned_rad);
            }
            let found = heading_offset(&ROBOT, &runs).unwrap();
            assert!((found - turned_rad).abs() < 0.005, "{turned_rad}: {found}");
        }
    }
}
