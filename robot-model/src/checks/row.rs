//! Single rows that no robot drove: a count that jumps, a position that is elsewhere for one picture; and headings
//! that are turned against the way the robot rolls in all runs.

use crate::kinematics::pose::Pose;
use crate::numeric::angle::wrap;
use crate::recording::run::{PoseMeasurement, Recording, Robot};

use super::reckoning::{FAR_M, Reckoned, at, median, of_side};

/// A single row that is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BadRow {
    /// A wheel rolled so far in one step as it never does.
    Jump {
        /// Whether it is the right wheel.
        right: bool,
        /// The row after the step \[s\].
        t_s: f64,
        /// How far it would have rolled \[m\].
        rolled_m: f64,
    },
    /// A position that is elsewhere than those before and after it.
    Spike {
        /// When \[s\].
        t_s: f64,
        /// How far off it is \[m\].
        off_m: f64,
    },
}

/// Nine of ten steps in which the wheel turns at all, if there are so many, are slower than this many times; and a jump is no slower than this \[m/s\], nor shorter \[m\].
const MOVING_MIN: usize = 5;
const JUMP_TIMES: f64 = 8.0;
const JUMP_MPS: f64 = 0.5;
const JUMP_M: f64 = 0.03;
/// A spike is off by so much \[m\], and by so many times the middle step between pictures; pictures that are more apart
/// than this \[s\] say nothing of one between.
const SPIKE_M: f64 = 0.1;
const SPIKE_TIMES: f64 = 10.0;
const SPIKE_S: f64 = 1.0;
/// Fewer tell nothing of what is usual.
const STEPS_MIN: usize = 20;
/// A heading that is turned against the way by less may be a drift or a crooked axle \[rad\]; and it must be so in so
/// many runs, in nearly all of them alike.
const TURNED_MIN_RAD: f64 = 0.0175;
/// By more, they count from another axis.
const TURNED_MAX_RAD: f64 = 0.6;
const TURNED_RUNS_MIN: usize = 4;
const ALIKE: f64 = 0.25;
/// On a straight way wheels turn it by no more than this \[rad\].
const STRAIGHT_RAD: f64 = 0.03;

/// The first row of a run that no robot drove.
pub fn bad_row(robot: &Robot, run: &Recording) -> Option<BadRow> {
    let jumps = [false, true].into_iter().filter_map(|right| jump(robot, run, right));
    let time = |it: &BadRow| match it {
        BadRow::Jump { t_s, .. } | BadRow::Spike { t_s, .. } => *t_s,
    };
    jumps.chain(spike(robot, run)).min_by(|a, b| time(a).total_cmp(&time(b)))
}

fn jump(robot: &Robot, run: &Recording, right: bool) -> Option<BadRow> {
    if run.wheels.len() <= STEPS_MIN {
        return None;
    }
    let steps = || {
        run.wheels.windows(2).map(|it| {
            let turned_rad = of_side(it[1].phi_rad, right) - of_side(it[0].phi_rad, right);
            let rolled_m = (turned_rad * robot.wheel_radius_m).abs();
            (it[1].t_s, rolled_m, rolled_m / (it[1].t_s - it[0].t_s))
        })
    };
    let mut speeds: Vec<f64> = steps().map(|it| it.2).filter(|it| *it > 0.0).collect();
    speeds.sort_by(f64::total_cmp);
    // A robot that stands nearly throughout may drive in between; in one or two steps it does not.
    let drives = speeds.len() >= MOVING_MIN;
    let usual_mps = if drives { speeds[speeds.len() * 9 / 10] } else { 0.0 };
    let limit_mps = (JUMP_TIMES * usual_mps).max(JUMP_MPS);
    let (t_s, rolled_m, _) = steps().find(|it| it.2 > limit_mps && it.1 > JUMP_M)?;
    Some(BadRow::Jump { right, t_s, rolled_m })
}

fn spike(robot: &Robot, run: &Recording) -> Option<BadRow> {
    let led = Reckoned::of(robot, run);
    let seen: Vec<(f64, [f64; 2])> =
        run.measured_poses.iter().filter_map(|it| Some((it.t_s, it.position_m?))).collect();
    if seen.len() <= STEPS_MIN {
        return None;
    }
    let apart_m = |a: &(f64, [f64; 2]), b: &(f64, [f64; 2])| {
        let gap_m = (b.1[0] - a.1[0]).hypot(b.1[1] - a.1[1]);
        gap_m - led.rolled(a.0, b.0).0
    };
    let usual_m = median(seen.windows(2).map(|it| apart_m(&it[0], &it[1]).abs()).collect())?;
    let limit_m = SPIKE_M.max(SPIKE_TIMES * usual_m);
    let off = |it: &[(f64, [f64; 2])]| {
        let off_m = apart_m(&it[0], &it[1]).min(apart_m(&it[1], &it[2]));
        let near = it[2].0 - it[0].0 < SPIKE_S && apart_m(&it[0], &it[2]) < 0.5 * off_m;
        (off_m > limit_m && near).then_some(BadRow::Spike { t_s: it[1].0, off_m })
    };
    seen.windows(3).find_map(off)
}

/// How much headings are turned against the way that the robot rolls, if it is alike in nearly all runs \[rad\].
pub fn crooked(robot: &Robot, runs: &[Recording]) -> Option<f64> {
    let each: Vec<f64> = runs.iter().filter_map(|run| median(turned(robot, run))).collect();
    let turned_rad =
        median(each.clone()).filter(|it| (TURNED_MIN_RAD..TURNED_MAX_RAD).contains(&it.abs()))?;
    let alike = each.iter().filter(|it| (*it - turned_rad).abs() < ALIKE * turned_rad.abs());
    (each.len() >= TURNED_RUNS_MIN && 10 * alike.count() >= 9 * each.len()).then_some(turned_rad)
}

/// On straight ways: by how much the heading is left of the way that the robot went, ahead or back.
fn turned(robot: &Robot, run: &Recording) -> Vec<f64> {
    let led = Reckoned::of(robot, run);
    let by_wheels = |it: &PoseMeasurement| -> Pose { at(run, &led.poses, it.t_s) };
    let mut found = Vec::new();
    let mut from: Option<&PoseMeasurement> = None;
    for measurement in &run.measured_poses {
        let (Some([x_m, y_m]), Some(heading_rad)) =
            (measurement.position_m, measurement.heading_rad)
        else {
            continue;
        };
        let Some(it) = from else {
            from = Some(measurement);
            continue;
        };
        let to = by_wheels(measurement).seen_from(by_wheels(it));
        let way_m = led.rolled(it.t_s, measurement.t_s).0;
        let straight = to.heading_rad.abs() < STRAIGHT_RAD && to.x_m.abs() > 0.98 * way_m;
        if !straight {
            from = Some(measurement);
        } else if let (true, Some([x0_m, y0_m])) = (way_m > FAR_M, it.position_m) {
            let (dx_m, dy_m) = ((x_m - x0_m) * to.x_m.signum(), (y_m - y0_m) * to.x_m.signum());
            let between_rad =
                heading_rad - wrap(heading_rad - it.heading_rad.unwrap_or(heading_rad)) / 2.0;
            found.push(wrap(between_rad - dy_m.atan2(dx_m)));
            from = Some(measurement);
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
    fn a_robot_that_is_merely_wrong_has_no_such_rows_and_no_crooked_headings() {
        for (id, values) in ALONE {
            let runs = campaign(&full_plan(), &[term(id, values)], 3).runs;
            assert_eq!(runs.iter().find_map(|it| bad_row(&ROBOT, it)), None, "{id}");
            assert_eq!(crooked(&ROBOT, &runs), None, "{id}");
        }
    }

    #[test]
    fn a_robot_that_stands_nearly_throughout_and_then_drives_fast_is_sound() {
        let mut run = runs().into_iter().find(|it| it.name.starts_with("out_and_back")).unwrap();
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
        // One row of a robot that stands.
        run.wheels.truncate(200);
        run.wheels[100].phi_rad.left = 30.0;
        let found = bad_row(&ROBOT, &run);
        assert!(matches!(found, Some(BadRow::Jump { right: false, .. })), "{found:?}");
    }

    #[test]
    fn one_row_that_is_off_is_found() {
        for run in runs().iter().filter(|it| it.wheels.len() > 40) {
            let at_s = run.wheels[30].t_s;
            for (rows, right) in [(30..31, false), (30..run.wheels.len(), true)] {
                let mut wrong = run.clone();
                for it in &mut wrong.wheels[rows] {
                    let phi_rad = if right { &mut it.phi_rad.right } else { &mut it.phi_rad.left };
                    *phi_rad += 7.0;
                }
                let found = bad_row(&ROBOT, &wrong);
                assert!(
                    matches!(found, Some(BadRow::Jump { right: side, t_s, .. }) if side == right && t_s == at_s),
                    "{}: {found:?}",
                    run.name
                );
            }
            let mut wrong = run.clone();
            let middle = wrong.measured_poses.len() / 2;
            if middle < STEPS_MIN {
                continue;
            }
            wrong.measured_poses[middle].position_m =
                run.measured_poses[middle].position_m.map(|[x, y]| [x, y + 0.5]);
            let found = bad_row(&ROBOT, &wrong);
            assert!(
                matches!(found, Some(BadRow::Spike { t_s, off_m }) if t_s == run.measured_poses[middle].t_s && off_m > 0.4),
                "{}: {found:?}",
                run.name
            );
        }
    }

    #[test]
    fn headings_that_are_turned_in_all_runs_are_found_with_their_sign() {
        for turned_rad in [-0.3, -0.03, 0.03, 0.3] {
            let mut runs = runs();
            for it in runs.iter_mut().flat_map(|it| &mut it.measured_poses) {
                it.heading_rad = it.heading_rad.map(|it| it + turned_rad);
            }
            let found = crooked(&ROBOT, &runs).unwrap();
            assert!((found - turned_rad).abs() < 0.005, "{turned_rad}: {found}");
        }
    }
}
