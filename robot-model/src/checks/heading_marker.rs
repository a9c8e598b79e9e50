//! Do the headings of all runs point a little away from where the robot rolls, as of a marker that sits crooked?
//!
//! A fit can live with that; larger angles are hypotheses.

use crate::kinematics::pose::Pose;
use crate::numeric::angle::wrap;
use crate::numeric::median::median;
use crate::recording::run::{PoseMeasurement, Recording, Robot};

use super::dead_reckoning::{Reckoned, at};

/// A shorter distance by the wheels does not show a direction \[m\].
const FAR_M: f64 = 0.2;
/// A smaller angle between heading and travel may be a drift or a crooked axle \[rad\].
const TURNED_MIN_RAD: f64 = 0.0175;
/// With a larger one, headings count from another axis \[rad\].
const TURNED_MAX_RAD: f64 = 0.6;
/// It takes this many runs, nine of ten of which agree within this share.
const TURNED_RUNS_MIN: usize = 4;
const ALIKE: f64 = 0.25;
/// On a straight path the wheels turn the robot by no more than this \[rad\].
const STRAIGHT_RAD: f64 = 0.03;

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
    use crate::tests::synthetic::{ROBOT, each_alone, sound};

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
}
