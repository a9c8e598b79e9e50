//! Do the headings of all runs point a little away from where the robot rolls, as of a marker that sits crooked?
//!
//! A fit can live with small angles, which are taken out before it; larger ones are hypotheses.
//!
//! On a straight path, headings point where positions go. On a curve they do so in its middle, as far as the wheels say; a
//! marker ahead of the axle, and a robot that slips sideways, see the path turned in proportion to the turn:
//!
//! ```text
//! heading - travel, as measured and by the wheels = turned + s (turn, reversed if backwards)           (1)
//! turned = turned at the run's beginning + r (time in the run), r the same in all runs                   (2)
//! ```
//!
//! A heading that drifts, as of a gyro whose bias was not taken off, points away from the travel more and more: (2) parts
//! that from the marker, and leaves it to the effect `heading_drift`.

use crate::kinematics::pose::Pose;
use crate::numeric::angle::wrap;
use crate::numeric::median::median;
use crate::recording::run::{PoseMeasurement, Recording, Robot};

use super::dead_reckoning::{Reckoned, at};

/// A shorter distance by the wheels does not show a direction \[m\].
const FAR_M: f64 = 0.2;
/// A smaller angle between heading and travel may be a drift or a crooked axle \[rad\].
const TURNED_MIN_RAD: f64 = 0.0175;
/// With a larger one, headings count from another axis: see the hypotheses \[rad\].
const TURNED_MAX_RAD: f64 = 0.35;
/// It takes this many runs that agree within this share, four of five of all.
const TURNED_RUNS_MIN: usize = 4;
const ALIKE: f64 = 0.25;
/// On a straight path the wheels turn the robot by no more than this, and on a curve that shows a direction \[rad\].
const STRAIGHT_RAD: f64 = 0.03;
const CURVE_RAD: f64 = 0.8;
/// A path that goes no way back is as long as its chord but for this share.
const NO_WAY_BACK: f64 = 0.9;
/// Without straight paths, it takes this many curves, to both sides.
const CURVES_MIN: usize = 8;
/// r of (2) is told from this many paths on, if it is this many times its standard error.
const DRIFT_PATHS_MIN: usize = 12;
const DRIFT_SIGMAS: f64 = 5.0;

/// The angle from the direction of travel to the heading, if nearly all runs agree on it \[rad\].
pub fn heading_offset(robot: &Robot, runs: &[Recording]) -> Option<f64> {
    let mut paths: Vec<Vec<Path>> = runs.iter().map(|run| paths(robot, run)).collect();
    let drift_rad_s = drift_rad_s(&paths);
    for path in paths.iter_mut().flatten() {
        path.turned_rad -= drift_rad_s * path.time_s;
    }
    let each: Vec<f64> = paths.iter().filter_map(|paths| turned(paths)).collect();
    let clear = |turned_rad: &f64| (TURNED_MIN_RAD..TURNED_MAX_RAD).contains(&turned_rad.abs());
    let turned_rad = median(each.clone()).filter(clear)?;
    let alike = |run: &&f64| (*run - turned_rad).abs() < ALIKE * turned_rad.abs();
    let alike = each.iter().filter(alike).count();
    (alike >= TURNED_RUNS_MIN && 5 * alike >= 4 * each.len()).then_some(turned_rad)
}

/// A path between two poses.
struct Path {
    /// Its middle, from the run's first sample on \[s\].
    time_s: f64,
    /// The turn by the wheels, reversed if backwards \[rad\].
    turn_rad: f64,
    /// The angle from the direction of travel, reversed if backwards, to the heading, less that by the wheels \[rad\].
    turned_rad: f64,
}

/// r of (2), by how the angle changes within runs; zero if it does not stand out \[rad/s\].
fn drift_rad_s(runs: &[Vec<Path>]) -> f64 {
    let mut centred: Vec<(f64, f64)> = Vec::new();
    for run in runs {
        let straight = || run.iter().filter(|path| path.turn_rad.abs() < STRAIGHT_RAD);
        let n = straight().count() as f64;
        let mean = |of: fn(&Path) -> f64| straight().map(of).sum::<f64>() / n;
        let [time_s, turned_rad] = [mean(|path| path.time_s), mean(|path| path.turned_rad)];
        centred.extend(straight().map(|path| (path.time_s - time_s, path.turned_rad - turned_rad)));
    }
    let (both, square) = centred.iter().fold((0.0, 0.0), |(both, square), (time, turned)| {
        (both + time * turned, square + time * time)
    });
    if centred.len() < DRIFT_PATHS_MIN || square <= 0.0 {
        return 0.0;
    }
    let rate = both / square;
    let left: f64 = centred.iter().map(|(time, turned)| (turned - rate * time).powi(2)).sum();
    let sigma = (left / (centred.len() as f64 * square)).sqrt();
    if rate.abs() > DRIFT_SIGMAS * sigma { rate } else { 0.0 }
}

/// By the median of straight paths, or by (1).
fn turned(paths: &[Path]) -> Option<f64> {
    let is_straight = |path: &&Path| path.turn_rad.abs() < STRAIGHT_RAD;
    let straight: Vec<f64> = paths.iter().filter(is_straight).map(|path| path.turned_rad).collect();
    let to_both_sides = paths.iter().any(|path| path.turn_rad > 0.0)
        && paths.iter().any(|path| path.turn_rad < 0.0);
    if straight.len() >= CURVES_MIN || paths.len() < CURVES_MIN || !to_both_sides {
        return median(straight);
    }
    let n = paths.len() as f64;
    let mean = |of: fn(&Path) -> f64| paths.iter().map(of).sum::<f64>() / n;
    let [turn, turned] = [mean(|path| path.turn_rad), mean(|path| path.turned_rad)];
    let (both, square) = paths.iter().fold((0.0, 0.0), |(both, square), path| {
        let x = path.turn_rad - turn;
        (both + x * (path.turned_rad - turned), square + x * x)
    });
    let slope = if square > 0.0 { both / square } else { 0.0 };
    median(paths.iter().map(|path| path.turned_rad - slope * path.turn_rad).collect())
}

/// The paths of a run that show a direction, one after the other.
fn paths(robot: &Robot, run: &Recording) -> Vec<Path> {
    let reckoned = Reckoned::of(robot, run);
    let by_wheels = |pose: &PoseMeasurement| -> Pose { at(run, &reckoned.poses, pose.t_s) };
    let whole = run
        .measured_poses
        .iter()
        .filter_map(|pose| Some((pose, pose.position_m?, pose.heading_rad?)));
    let mut found = Vec::new();
    let mut start: Option<(&PoseMeasurement, [f64; 2], f64)> = None;
    for (pose, [x_m, y_m], heading_rad) in whole {
        let Some((from, [x0_m, y0_m], from_rad)) = start else {
            start = Some((pose, [x_m, y_m], heading_rad));
            continue;
        };
        let by_wheels = by_wheels(pose).seen_from(by_wheels(from));
        let path_m = reckoned.rolled(from.t_s, pose.t_s).0;
        let chord_m = by_wheels.x_m.hypot(by_wheels.y_m);
        if chord_m < NO_WAY_BACK * path_m || by_wheels.heading_rad.abs() > CURVE_RAD {
            start = Some((pose, [x_m, y_m], heading_rad));
        } else if path_m > FAR_M {
            let sign = by_wheels.x_m.signum();
            // From the direction of travel to the heading in the middle of the path.
            let to_heading = |dx_m: f64, dy_m: f64, from_rad: f64, turn_rad: f64| {
                wrap(from_rad + turn_rad / 2.0 - (sign * dy_m).atan2(sign * dx_m))
            };
            let measured =
                to_heading(x_m - x0_m, y_m - y0_m, from_rad, wrap(heading_rad - from_rad));
            let expected = to_heading(by_wheels.x_m, by_wheels.y_m, 0.0, by_wheels.heading_rad);
            let turn_rad = sign * by_wheels.heading_rad;
            let time_s = f64::midpoint(from.t_s, pose.t_s) - run.wheels[0].t_s;
            found.push(Path { time_s, turn_rad, turned_rad: wrap(measured - expected) });
            start = Some((pose, [x_m, y_m], heading_rad));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::nominal_run::Piece;
    use crate::tests::synthetic::{ROBOT, campaign, each_alone, full_plan, sound, term};

    #[test]
    fn a_robot_that_is_merely_inaccurate_has_no_crooked_headings() {
        for (id, campaign) in each_alone() {
            assert_eq!(heading_offset(&ROBOT, &campaign.runs), None, "{id}");
        }
    }

    #[test]
    fn headings_that_are_turned_in_all_runs_are_found_with_their_sign() {
        for turned_rad in [-0.3, -0.03, 0.03, 0.3] {
            let mut runs = sound().runs.clone();
            for pose in runs.iter_mut().flat_map(|run| &mut run.measured_poses) {
                pose.heading_rad = pose.heading_rad.map(|rad| rad + turned_rad);
            }
            let found = heading_offset(&ROBOT, &runs).unwrap();
            assert!((found - turned_rad).abs() < 0.005, "{turned_rad}: {found}");
        }
    }

    #[test]
    fn a_heading_that_drifts_is_no_crooked_marker_and_hides_none() {
        for (drift_rad_s, turned_rad) in
            [(0.002, 0.0), (-0.003, 0.0), (0.002, 0.04), (-0.002, -0.05)]
        {
            let mut runs = campaign(&full_plan(), &[term("heading_drift", &[drift_rad_s])], 5).runs;
            for pose in runs.iter_mut().flat_map(|run| &mut run.measured_poses) {
                pose.heading_rad = pose.heading_rad.map(|rad| rad + turned_rad);
            }
            let found = heading_offset(&ROBOT, &runs);
            match turned_rad {
                0.0 => assert_eq!(found, None, "{drift_rad_s}"),
                _ => {
                    assert!((found.unwrap() - turned_rad).abs() < 0.005, "{drift_rad_s}: {found:?}")
                }
            }
        }
    }

    #[test]
    fn they_are_found_on_curves_alone_whatever_else_the_robot_does() {
        // S-curves, driven with a marker ahead of the axle, with side slip and on a slope.
        let arc = |turn_rad| Piece::Arc { radius_m: 0.5, turn_rad, speed_mps: 0.3 };
        let plan: Vec<_> = (0..6)
            .map(|k| {
                let pieces = [1.2, -1.5, 0.9, -1.1, 1.4, -0.8, 1.0, -1.3].map(arc).to_vec();
                (format!("curves_{k}"), f64::from(k), pieces)
            })
            .collect();
        for truth in [
            vec![],
            vec![term("marker_offset", &[0.03, -0.02])],
            vec![term("side_slip", &[0.05])],
            vec![term("carpet_drift", &[0.005, 0.003])],
        ] {
            let mut runs = campaign(&plan, &truth, 3).runs;
            assert_eq!(heading_offset(&ROBOT, &runs), None, "{truth:?}");
            for pose in runs.iter_mut().flat_map(|run| &mut run.measured_poses) {
                pose.heading_rad = pose.heading_rad.map(|rad| rad + 0.12);
            }
            let found = heading_offset(&ROBOT, &runs).unwrap_or(0.0);
            assert!((found - 0.12).abs() < 0.01, "{truth:?}: {found}");
        }
    }
}
