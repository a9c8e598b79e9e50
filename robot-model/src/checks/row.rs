//! Which single rows are impossible: a count that jumps, a position that is elsewhere for one frame? And do the
//! headings of all runs point away from where the robot rolls?
//!
//! Columns that are wrong throughout are left to `units.rs`, last poses to `end_pose.rs`.

use crate::kinematics::pose::Pose;
use crate::numeric::angle::wrap;
use crate::recording::run::{PoseMeasurement, Recording, Robot};

use super::dead_reckoning::{FAR_M, Reckoned, at, median, of_side};

/// A single impossible row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BadRow {
    /// A wheel rolled much farther in one step than in any other.
    Jump {
        /// Whether it is the right wheel.
        right: bool,
        /// The row after the step \[s\].
        t_s: f64,
        /// How far it would have rolled \[m\].
        rolled_m: f64,
    },
    /// A position far from those before and after it.
    Spike {
        /// When \[s\].
        t_s: f64,
        /// How far off it is \[m\].
        off_m: f64,
    },
}

/// The usual speed of a wheel is the 90 % quantile over the steps in which it turns, if there are this many.
const MOVING_MIN: usize = 5;
/// A jump is this many times as fast as usual, at least this fast \[m/s\] and this long \[m\].
const JUMP_TIMES: f64 = 8.0;
const JUMP_MPS: f64 = 0.5;
const JUMP_M: f64 = 0.03;
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

/// The first impossible row of a run.
pub fn bad_row(robot: &Robot, run: &Recording) -> Option<BadRow> {
    let jumps = [false, true].into_iter().filter_map(|right| jump(robot, run, right));
    let time = |row: &BadRow| match row {
        BadRow::Jump { t_s, .. } | BadRow::Spike { t_s, .. } => *t_s,
    };
    jumps.chain(spike(robot, run)).min_by(|a, b| time(a).total_cmp(&time(b)))
}

fn jump(robot: &Robot, run: &Recording, right: bool) -> Option<BadRow> {
    if run.wheels.len() <= STEPS_MIN {
        return None;
    }
    let steps = || {
        run.wheels.windows(2).map(|pair| {
            let turned_rad = of_side(pair[1].phi_rad, right) - of_side(pair[0].phi_rad, right);
            let rolled_m = (turned_rad * robot.wheel_radius_m).abs();
            (pair[1].t_s, rolled_m, rolled_m / (pair[1].t_s - pair[0].t_s))
        })
    };
    let mut speeds: Vec<f64> = steps().map(|(.., mps)| mps).filter(|mps| *mps > 0.0).collect();
    speeds.sort_by(f64::total_cmp);
    // A robot that stands most of the time may drive in between, but not for one or two steps.
    let drives = speeds.len() >= MOVING_MIN;
    let usual_mps = if drives { speeds[speeds.len() * 9 / 10] } else { 0.0 };
    let limit_mps = (JUMP_TIMES * usual_mps).max(JUMP_MPS);
    let jumps = |(_, rolled_m, mps): &(f64, f64, f64)| *mps > limit_mps && *rolled_m > JUMP_M;
    let (t_s, rolled_m, _) = steps().find(jumps)?;
    Some(BadRow::Jump { right, t_s, rolled_m })
}

fn spike(robot: &Robot, run: &Recording) -> Option<BadRow> {
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
        (off_m > limit_m && near).then_some(BadRow::Spike { t_s: row.0, off_m })
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
    use crate::kinematics::wheel_pair::WheelPair;
    use crate::recording::run::WheelSample;
    use crate::tests::synthetic::{ALONE, ROBOT, campaign, full_plan, term};

    fn runs() -> Vec<Recording> {
        campaign(&full_plan(), &[], 3).runs
    }

    #[test]
    fn a_robot_that_is_merely_inaccurate_has_no_bad_rows_and_no_crooked_headings() {
        for (id, values) in ALONE {
            let runs = campaign(&full_plan(), &[term(id, values)], 3).runs;
            assert_eq!(runs.iter().find_map(|run| bad_row(&ROBOT, run)), None, "{id}");
            assert_eq!(heading_offset(&ROBOT, &runs), None, "{id}");
        }
    }

    #[test]
    fn a_robot_that_stands_most_of_the_time_and_then_drives_fast_is_sound() {
        let mut run = runs().into_iter().find(|run| run.name.starts_with("out_and_back")).unwrap();
        let sample =
            |t_s: f64, phi_rad: f64| WheelSample { t_s, phi_rad: WheelPair::new(phi_rad, phi_rad) };
        run.measured_poses.clear();
        // 1.2 m/s for a second, after twenty at rest.
        run.wheels = (0..=210)
            .map(|k| {
                sample(
                    0.1 * f64::from(k),
                    1.2 / ROBOT.wheel_radius_m * (0.1 * f64::from(k) - 20.0).max(0.0),
                )
            })
            .collect();
        assert_eq!(bad_row(&ROBOT, &run), None);
        // One jump of a robot that stands.
        run.wheels.truncate(200);
        run.wheels[100].phi_rad.left = 30.0;
        let found = bad_row(&ROBOT, &run);
        assert!(matches!(found, Some(BadRow::Jump { right: false, .. })), "{found:?}");
    }

    #[test]
    fn one_bad_row_is_found() {
        for run in runs().iter().filter(|run| run.wheels.len() > 40) {
            let at_s = run.wheels[30].t_s;
            for (rows, right) in [(30..31, false), (30..run.wheels.len(), true)] {
                let mut wrong = run.clone();
                for sample in &mut wrong.wheels[rows] {
                    let phi_rad = &mut sample.phi_rad;
                    let wheel_rad = if right { &mut phi_rad.right } else { &mut phi_rad.left };
                    *wheel_rad += 7.0;
                }
                let found = bad_row(&ROBOT, &wrong);
                let Some(BadRow::Jump { right: side, t_s, .. }) = found else {
                    panic!("{}: {found:?}", run.name);
                };
                assert_eq!((side, t_s), (right, at_s), "{}", run.name);
            }
            let mut wrong = run.clone();
            let middle = wrong.measured_poses.len() / 2;
            if middle < STEPS_MIN {
                continue;
            }
            wrong.measured_poses[middle].position_m =
                run.measured_poses[middle].position_m.map(|[x, y]| [x, y + 0.5]);
            let found = bad_row(&ROBOT, &wrong);
            let at_s = run.measured_poses[middle].t_s;
            assert!(
                matches!(found, Some(BadRow::Spike { t_s, off_m }) if t_s == at_s && off_m > 0.4),
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
