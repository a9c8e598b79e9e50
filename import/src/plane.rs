//! Poses in space as poses on the floor: which axis is up, and where the body heads.
//!
//! Where the tracker's axes lie askew to the floor, as those of a camera, the floor is the plane that the positions lie in.
//!
//! The heading is the direction of an axis of the body, projected onto the floor, so that a marker may be tilted or upside
//! down: what is left is a constant angle to the robot's own heading.

use nalgebra::{Matrix3, Rotation3, SymmetricEigen, Vector3};

use crate::angle::{nearest, wrapped};
use crate::log::{Pose3, PoseLog};

/// A pose on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatPose {
    /// When \[s\].
    pub t_s: f64,
    /// Where \[m\].
    pub position_m: [f64; 2],
    /// The heading, unwrapped \[rad\].
    pub heading_rad: Option<f64>,
}

/// Poses on the floor, and what was found out about their axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlatPoses {
    /// The poses.
    pub poses: Vec<FlatPose>,
    /// What a user should know.
    pub said: Vec<String>,
}

/// Another axis than z is up if z extends this many times as far as that.
const UP_TIMES: f64 = 5.0;
/// Headings that never differ by more were not measured \[rad\].
const TURNED_MIN_RAD: f64 = 1e-6;
/// The length of a quaternion that is one.
const LENGTH: std::ops::RangeInclusive<f64> = 0.9..=1.1;
/// The body's x axis gives the heading if so much of it lies in the floor.
const LEVEL: f64 = 0.7;

/// The poses of a log on the floor.
pub fn flat(log: &PoseLog) -> FlatPoses {
    let mut said = Vec::new();
    let askew = askew(&log.poses);
    let up = askew.map_or_else(|| up_axis(&log.poses), |(up, _)| up);
    let level = |[x, y, z]: [f64; 3]| -> [f64; 3] {
        askew.map_or([x, y, z], |(_, level)| (level * Vector3::new(x, y, z)).into())
    };
    if let Some((_, level)) = askew {
        let askew_deg = level.angle().to_degrees();
        said.push(format!(
            "the floor lies askew to the tracker's axes, by {askew_deg:.1} degrees: levelled"
        ));
    }
    if up != 2 {
        let name = ["x", "y"][up];
        said.push(format!("{name} points up: the floor is the plane of the two others"));
    }
    // The two axes of the floor, so that with the one that is up they are right-handed.
    let floor = [(up + 1) % 3, (up + 2) % 3];
    let sound =
        |q: &[f64; 4]| LENGTH.contains(&q.iter().map(|part| part * part).sum::<f64>().sqrt());
    let unsound =
        log.poses.iter().filter(|pose| pose.orientation.is_some_and(|q| !sound(&q))).count();
    if unsound > 0 {
        said.push(format!("{unsound} orientations are no unit quaternions and were left out"));
    }
    let axis = body_axis(&log.poses, up, sound, level);
    let heading = |pose: &Pose3| {
        let q = pose.orientation.filter(sound)?;
        let direction = level(turned(&q, axis));
        Some(direction[floor[1]].atan2(direction[floor[0]]))
    };
    let headings: Vec<Option<f64>> = log.poses.iter().map(heading).collect();
    let back_to_front = back_to_front(&log.poses, &headings);
    let flips = back_to_front.iter().filter(|flips| **flips).count();
    if flips > 0 {
        said.push(format!(
            "{flips} of {} poses are turned by half a turn from those before and after, as of a marker seen back to front: left out",
            log.poses.len()
        ));
    }
    let mut last_rad: Option<f64> = None;
    let mut poses: Vec<FlatPose> = log
        .poses
        .iter()
        .zip(headings)
        .zip(back_to_front)
        .filter(|(_, flips)| !flips)
        .map(|((pose, wrapped), _)| {
            let heading_rad = wrapped.map(|rad| {
                let before = last_rad.unwrap_or(rad);
                nearest(rad, before)
            });
            last_rad = heading_rad.or(last_rad);
            let position_m = level(pose.position_m);
            FlatPose { t_s: pose.t_s, position_m: floor.map(|axis| position_m[axis]), heading_rad }
        })
        .collect();
    let headings = || poses.iter().filter_map(|pose| pose.heading_rad);
    let (low, high) = headings()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), rad| (low.min(rad), high.max(rad)));
    if headings().next().is_some() && high - low < TURNED_MIN_RAD {
        said.push("all orientations are the same: they were not measured, and are left out".into());
        poses.iter_mut().for_each(|pose| pose.heading_rad = None);
    }
    FlatPoses { poses, said }
}

/// Turned by more is back to front, and turned by less is not turned \[rad\]; for so many frames at most, this near to each other \[s\].
const BACK_RAD: f64 = 2.0;
const NOT_TURNED_RAD: f64 = 0.7;
const FLIP_FRAMES_MAX: usize = 3;
const FLIP_S: f64 = 0.6;
/// More than this share is no marker that is mistaken now and then.
const FLIPS_MAX: f64 = 0.2;

/// Which poses are turned by about half a turn from those before and after them. What else is elsewhere shows by the wheels; this
/// must go before headings are followed from pose to pose.
fn back_to_front(poses: &[Pose3], headings: &[Option<f64>]) -> Vec<bool> {
    let mut flips = vec![false; poses.len()];
    let known: Vec<(usize, f64)> =
        headings.iter().enumerate().filter_map(|(k, rad)| Some((k, (*rad)?))).collect();
    let turn = |a: usize, b: usize| wrapped(known[b].1 - known[a].1).abs();
    let mut before = 0;
    while before + 2 < known.len() {
        let after = (before + 2..=before + 1 + FLIP_FRAMES_MAX).find(|after| {
            *after < known.len()
                && poses[known[*after].0].t_s - poses[known[before].0].t_s < FLIP_S
                && turn(before, *after) < NOT_TURNED_RAD
                && (before + 1..*after)
                    .all(|k| turn(before, k) > BACK_RAD && turn(k, *after) > BACK_RAD)
        });
        if let Some(after) = after {
            known[before + 1..after].iter().for_each(|(k, _)| flips[*k] = true);
        }
        before = after.unwrap_or(before + 1);
    }
    let count = flips.iter().filter(|flip| **flip).count();
    if count as f64 > FLIPS_MAX * known.len() as f64 {
        flips.fill(false);
    }
    flips
}

/// A floor that lies askew by less is level: lengths differ by less than 4e-5 \[rad\].
const LEVEL_RAD: f64 = 0.009;
/// Levelled, positions must leave the floor by less by this factor.
const LEVEL_TIMES: f64 = 2.0;
/// Positions that lie further from the floor than this many times the median, and than this \[m\], are none.
const OFF_TIMES: f64 = 5.0;
const OFF_M: f64 = 2e-3;
/// Three axes are found in a few rounds.
const ROUNDS_MAX: usize = 1000;
/// So many positions show where the floor is, of so large a share.
const ON_FLOOR_MIN: (usize, f64) = (20, 0.7);

/// If the floor lies askew to the tracker's axes: the axis that is nearest to its normal, and the smallest rotation that levels it.
fn askew(poses: &[Pose3]) -> Option<(usize, Rotation3<f64>)> {
    let mut on_floor = on_a_plane(poses);
    let least = ON_FLOOR_MIN.0.max((ON_FLOOR_MIN.1 * poses.len() as f64) as usize);
    for round in 0.. {
        if on_floor.len() < least {
            return None;
        }
        let count = on_floor.len() as f64;
        let mean = on_floor.iter().sum::<Vector3<f64>>() / count;
        let squares: Matrix3<f64> =
            on_floor.iter().map(|at| (at - mean) * (at - mean).transpose()).sum();
        // Of a wild log squares may be no numbers: the search for axes ends all the same.
        let axes = SymmetricEigen::try_new(squares / count, f64::EPSILON, ROUNDS_MAX);
        let eigen = axes.filter(|axes| axes.eigenvalues.iter().all(|value| value.is_finite()))?;
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
        let spread = |k: usize| eigen.eigenvalues[order[k]].max(0.0).sqrt();
        let mut normal: Vector3<f64> = eigen.eigenvectors.column(order[0]).into();
        let up = normal.iamax();
        if normal[up] < 0.0 {
            normal = -normal;
        }
        let off = |at: &Vector3<f64>| (at - mean).dot(&normal).abs();
        let mut offs: Vec<f64> = on_floor.iter().map(off).collect();
        let middle = offs.len() / 2;
        let median = *offs.select_nth_unstable_by(middle, f64::total_cmp).1;
        let before = on_floor.len();
        on_floor.retain(|at| off(at) <= OFF_M.max(OFF_TIMES * median));
        if on_floor.len() < before && round < 10 {
            continue;
        }
        let along = squares[(up, up)].max(0.0).sqrt() / count.sqrt();
        let is_plane = spread(1) > UP_TIMES * spread(0);
        let is_askew = normal[up].min(1.0).acos() > LEVEL_RAD && along > LEVEL_TIMES * spread(0);
        let level = Rotation3::rotation_between(&normal, &Vector3::ith(up, 1.0));
        return level.filter(|_| is_plane && is_askew).map(|level| (up, level));
    }
    None
}

/// The positions near a plane through three of them, of some that which has the least median distance: a tracker that lost the
/// robot puts it somewhere else, often and far away.
fn on_a_plane(poses: &[Pose3]) -> Vec<Vector3<f64>> {
    const PLANES: usize = 100;
    const JUDGES: usize = 300;
    /// Its multiples spread evenly, whatever repeats itself in a drive.
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let at = |index: usize| Vector3::from(poses[index].position_m);
    let spread = |k: usize| ((k as f64 * GOLDEN).fract() * poses.len() as f64) as usize;
    let judges: Vec<Vector3<f64>> = (0..JUDGES.min(poses.len())).map(|k| at(spread(k))).collect();
    let mut best: Option<(f64, Vector3<f64>, Vector3<f64>)> = None;
    for k in (0..PLANES).filter(|_| !poses.is_empty()) {
        let [a, b, c] = [3 * k, 3 * k + 1, 3 * k + 2].map(|k| at(spread(k + JUDGES)));
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(1e-6) else { continue };
        let mut offs: Vec<f64> = judges.iter().map(|at| (at - a).dot(&normal).abs()).collect();
        let middle = offs.len() / 2;
        let median = *offs.select_nth_unstable_by(middle, f64::total_cmp).1;
        if best.is_none_or(|(least, ..)| median < least) {
            best = Some((median, a, normal));
        }
    }
    let all = poses.iter().map(|pose| Vector3::from(pose.position_m));
    let Some((median, a, normal)) = best else { return Vec::new() };
    let reach_m = OFF_M.max(OFF_TIMES * median);
    all.filter(|at| (at - a).dot(&normal).abs() <= reach_m).collect()
}

/// The axis along which the robot hardly moved, z in doubt.
fn up_axis(poses: &[Pose3]) -> usize {
    let spread = |axis: usize| {
        let mean =
            poses.iter().map(|pose| pose.position_m[axis]).sum::<f64>() / poses.len().max(1) as f64;
        let squares = poses.iter().map(|pose| (pose.position_m[axis] - mean).powi(2));
        (squares.sum::<f64>() / poses.len().max(1) as f64).sqrt()
    };
    let spreads = [0, 1, 2].map(spread);
    let candidate = if spreads[0] < spreads[1] { 0 } else { 1 };
    let is_least = spreads[2] > UP_TIMES * spreads[candidate];
    // Along a single line the two others are both small, and nothing can be told.
    let is_flat = spreads[1 - candidate] > UP_TIMES * spreads[candidate];
    if is_least && is_flat { candidate } else { 2 }
}

/// The axis of the body that lies most in the floor, x if it does.
fn body_axis(
    poses: &[Pose3],
    up: usize,
    sound: impl Fn(&[f64; 4]) -> bool,
    levelled: impl Fn([f64; 3]) -> [f64; 3],
) -> usize {
    let mut level = [0.0; 3];
    let mut count = 0.0;
    for q in poses.iter().filter_map(|pose| pose.orientation).filter(|q| sound(q)) {
        count += 1.0;
        for (axis, level) in level.iter_mut().enumerate() {
            *level += (1.0 - levelled(turned(&q, axis))[up].powi(2)).max(0.0);
        }
    }
    let is_level = |axis: usize| level[axis] >= LEVEL * count;
    (0..3).find(|axis| is_level(*axis)).unwrap_or(0)
}

/// A unit vector along an axis of the body, in the frame of the tracker.
fn turned(&[x, y, z, w]: &[f64; 4], axis: usize) -> [f64; 3] {
    match axis {
        0 => [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
        1 => [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
        _ => [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The product of two quaternions: first b, then a.
    fn product([ax, ay, az, aw]: [f64; 4], [bx, by, bz, bw]: [f64; 4]) -> [f64; 4] {
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ]
    }

    /// Round a circle to the left, on the floor whose normal is this axis; the marker is turned on the body.
    fn circle(up: usize, marker: [f64; 4]) -> PoseLog {
        let poses = (0..200)
            .map(|k| {
                let rad = f64::from(k) * 0.05;
                let (sin, cos) = rad.sin_cos();
                let mut position_m = [0.0; 3];
                (position_m[(up + 1) % 3], position_m[(up + 2) % 3]) = (sin, -cos);
                position_m[up] = 0.1 + 0.001 * sin;
                let mut yaw = [0.0, 0.0, 0.0, (rad / 2.0).cos()];
                yaw[up] = (rad / 2.0).sin();
                Pose3 {
                    t_s: f64::from(k) * 0.1,
                    position_m,
                    orientation: Some(product(yaw, marker)),
                }
            })
            .collect();
        PoseLog { poses, ..PoseLog::default() }
    }

    #[test]
    fn whichever_axis_is_up_and_however_the_marker_sits_turns_are_turns() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        // As it should be, upside down, on its nose, on its side.
        let markers = [
            [0.0, 0.0, 0.0, 1.0],
            [1.0, 0.0, 0.0, 0.0],
            [0.0, half, 0.0, half],
            [half, 0.0, 0.0, half],
        ];
        for up in 0..3 {
            for marker in markers {
                let flat = flat(&circle(up, marker));
                assert_eq!(flat.said.is_empty(), up == 2, "{:?}", flat.said);
                let (first, last) = (flat.poses[0], flat.poses[199]);
                let turned_rad = last.heading_rad.unwrap() - first.heading_rad.unwrap();
                assert!((turned_rad - 9.95).abs() < 1e-9, "{up} {marker:?}: {turned_rad}");
                assert!((first.position_m[1] + 1.0).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_floor_that_lies_askew_is_levelled_and_lost_positions_do_not_count() {
        for (about_x_deg, about_y_deg) in
            [(3.0_f64, 0.0_f64), (10.0, 5.0), (30.0, -40.0), (-120.0, 0.0)]
        {
            let frame = Rotation3::from_euler_angles(
                about_x_deg.to_radians(),
                about_y_deg.to_radians(),
                0.3,
            );
            let (axis, angle) = (frame.axis().unwrap(), frame.angle());
            let half = axis.scale((angle / 2.0).sin());
            let mut log = circle(2, [0.0, 0.0, 0.0, 1.0]);
            for (k, pose) in log.poses.iter_mut().enumerate() {
                let at = frame * Vector3::from(pose.position_m) + Vector3::new(0.5, -0.2, 2.0);
                // Twenty positions of a tracker that has lost the robot.
                pose.position_m = if k % 10 == 7 { [0.0; 3] } else { at.into() };
                let turn = [half.x, half.y, half.z, (angle / 2.0).cos()];
                pose.orientation = pose.orientation.map(|q| product(turn, q));
            }
            let flat = flat(&log);
            assert!(flat.said[0].contains("askew"), "{:?}", flat.said);
            let (first, last) = (flat.poses[0], flat.poses[199]);
            let turned_rad = last.heading_rad.unwrap() - first.heading_rad.unwrap();
            assert!((turned_rad.abs() - 9.95).abs() < 1e-3, "{turned_rad}");
            let apart_m = |a: usize, b: usize| {
                let [a, b] = [a, b].map(|k| flat.poses[k].position_m);
                (a[0] - b[0]).hypot(a[1] - b[1])
            };
            // Across the circle.
            assert!((apart_m(0, 63) - 2.0 * (63.0 * 0.05 / 2.0_f64).sin()).abs() < 1e-4);
            assert!((apart_m(30, 62) - 2.0 * (32.0 * 0.05 / 2.0_f64).sin()).abs() < 1e-4);
        }
        assert_eq!(askew(&circle(2, [0.0, 0.0, 0.0, 1.0]).poses), None);
    }

    #[test]
    fn wild_positions_have_no_floor_and_end() {
        for wild in [f64::NAN, f64::INFINITY, -1e300, 1e154] {
            for every in [1, 2, 50] {
                let mut log = circle(2, [0.0, 0.0, 0.0, 1.0]);
                for pose in log.poses.iter_mut().step_by(every) {
                    pose.position_m = pose.position_m.map(|m| m * wild);
                }
                let _ended = flat(&log);
            }
        }
    }

    #[test]
    fn orientations_that_nobody_measured_are_no_headings() {
        let mut log = circle(2, [0.0, 0.0, 0.0, 1.0]);
        log.poses.iter_mut().for_each(|pose| pose.orientation = Some([0.0, 0.0, 0.0, 1.0]));
        assert!(flat(&log).poses.iter().all(|pose| pose.heading_rad.is_none()));
        log.poses.iter_mut().for_each(|pose| pose.orientation = Some([0.0; 4]));
        let flat = flat(&log);
        assert!(flat.poses.iter().all(|pose| pose.heading_rad.is_none()));
        assert!(flat.said[0].contains("no unit quaternions"), "{:?}", flat.said);
    }
}
