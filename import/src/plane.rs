//! Poses in space as poses on the floor: which axis is up, and where the body heads.
//!
//! The heading is the direction of an axis of the body, projected onto the floor, so that a marker may be tilted or upside
//! down: what is left is a constant angle to the robot's own heading.

use std::f64::consts::TAU;

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
    let up = up_axis(&log.poses);
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
    let axis = body_axis(&log.poses, up, sound);
    let mut last_rad: Option<f64> = None;
    let mut poses: Vec<FlatPose> = log
        .poses
        .iter()
        .map(|pose| {
            let wrapped = pose.orientation.filter(sound).map(|q| {
                let direction = turned(&q, axis);
                direction[floor[1]].atan2(direction[floor[0]])
            });
            let heading_rad = wrapped.map(|rad| {
                let before = last_rad.unwrap_or(rad);
                rad + TAU * ((before - rad) / TAU).round()
            });
            last_rad = heading_rad.or(last_rad);
            FlatPose {
                t_s: pose.t_s,
                position_m: floor.map(|axis| pose.position_m[axis]),
                heading_rad,
            }
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
fn body_axis(poses: &[Pose3], up: usize, sound: impl Fn(&[f64; 4]) -> bool) -> usize {
    let mut level = [0.0; 3];
    let mut count = 0.0;
    for q in poses.iter().filter_map(|pose| pose.orientation).filter(|q| sound(q)) {
        count += 1.0;
        for (axis, level) in level.iter_mut().enumerate() {
            *level += (1.0 - turned(&q, axis)[up].powi(2)).max(0.0);
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
