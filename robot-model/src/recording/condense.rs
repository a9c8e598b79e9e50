//! Dense recordings, made lighter before anything is fitted: wheels some twenty times a second, and poses averaged over
//! a tenth of a second, or two tenths in a campaign of very many.
//!
//! Nothing is lost that a fit could use. Wheel angles are absolute: fewer samples of them are the same travel, as long as
//! there is one wherever a pose is measured. At an even speed within 60 ms, a robot that accelerates by 0.6 m/s^2 would be a
//! quarter of a millimetre off in their middle, too far on while it accelerates and too far back while it brakes, as by
//! backlash. Poses close together are first moved to one time by the wheels, then averaged: white noise falls by the root of
//! their number, as it would in a fit to each of them.

use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::angle::wrap;
use crate::recording::run::{PoseMeasurement, Recording, Robot, WheelSample};

/// Least time between samples of the wheels \[s\].
const WHEELS_S: f64 = 0.045;
/// A sample this close before a pose tells no more than the one at the pose \[s\].
const BESIDE_POSE_S: f64 = WHEELS_S / 2.0;
/// Samples are farther apart than this \[s\].
const SAME_S: f64 = 1e-3;
/// Poses within this time become one \[s\].
const POSES_S: f64 = 0.095;
/// Of a campaign with more poses than this, after that, poses within twice the time become one: an hour of driving tells the
/// same. Samples of the wheels stay as close as they are; twice as far apart, a robot that accelerates would look as if it
/// had backlash.
const POSES_MANY: usize = 50_000;

/// Where a lighter recording has samples of the wheels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WheelSamples {
    /// At even times, also where the times of poses are still to be corrected.
    Even,
    /// One at each pose, and at even times in between.
    AtPoses,
}

/// The time within which poses of a campaign of these runs become one \[s\].
pub(crate) fn poses_within_s<'a>(
    runs: impl Iterator<Item = &'a Recording>,
    samples: WheelSamples,
) -> f64 {
    let poses: usize = runs.map(|run| groups(&run.measured_poses, POSES_S).len()).sum();
    // Between even samples, the motion is not known well enough to bring poses farther apart to one time.
    let are_many = samples == WheelSamples::AtPoses && poses > POSES_MANY;
    if are_many { 2.0 * POSES_S } else { POSES_S }
}

/// A recording with fewer samples, where poses within a time become one; and how many became one, in the mean.
pub(crate) fn condensed(
    robot: &Robot,
    recording: &Recording,
    (samples, poses_s): (WheelSamples, f64),
) -> (Recording, f64) {
    let groups = groups(&recording.measured_poses, poses_s);
    let poses: Vec<PoseMeasurement> =
        groups.iter().map(|group| mean(robot, &recording.wheels, group)).collect();
    let many = recording.measured_poses.len() as f64 / poses.len().max(1) as f64;
    let wheels = match samples {
        WheelSamples::Even => thinned(&recording.wheels, &[]),
        WheelSamples::AtPoses => thinned(&recording.wheels, &poses),
    };
    (Recording { wheels, measured_poses: poses, ..recording.clone() }, many)
}

/// The first and last sample, one at each of these poses, and those between that are far enough apart; all where all are.
fn thinned(wheels: &[WheelSample], poses: &[PoseMeasurement]) -> Vec<WheelSample> {
    let [first, .., last] = wheels else { return wheels.to_vec() };
    if last.t_s - first.t_s >= WHEELS_S * (wheels.len() - 1) as f64 {
        return wheels.to_vec();
    }
    let within = first.t_s + SAME_S..last.t_s - SAME_S;
    let poses_s = poses.iter().map(|pose| pose.t_s).filter(|t_s| within.contains(t_s));
    let mut samples = wheels[1..].iter().peekable();
    let mut kept = vec![*first];
    let mut before_s = first.t_s;
    for t_s in poses_s {
        while let Some(sample) = samples.next_if(|sample| sample.t_s <= t_s) {
            if sample.t_s - before_s >= WHEELS_S && t_s - sample.t_s >= BESIDE_POSE_S {
                kept.push(*sample);
                before_s = sample.t_s;
            }
        }
        if t_s - before_s >= SAME_S {
            kept.push(WheelSample { t_s, phi_rad: angles(wheels, t_s) });
            before_s = t_s;
        }
    }
    for sample in samples {
        if sample.t_s - before_s >= WHEELS_S || sample.t_s == last.t_s {
            kept.push(*sample);
            before_s = sample.t_s;
        }
    }
    kept
}

/// Consecutive poses that become one. The first and the last stay alone, as a run begins and ends at rest.
fn groups(poses: &[PoseMeasurement], poses_s: f64) -> Vec<&[PoseMeasurement]> {
    let complete = poses.iter().all(|pose| pose.position_m.is_some() && pose.heading_rad.is_some());
    if !complete {
        return poses.chunks(1).collect();
    }
    let mut groups = Vec::new();
    let mut first = 0;
    for k in 1..=poses.len() {
        let ends = k == poses.len()
            || k == 1
            || k == poses.len() - 1
            || poses[k].t_s - poses[first].t_s >= poses_s;
        if ends {
            groups.push(&poses[first..k]);
            first = k;
        }
    }
    groups
}

/// The mean of poses, each moved to the middle of their times by the wheels.
fn mean(robot: &Robot, wheels: &[WheelSample], group: &[PoseMeasurement]) -> PoseMeasurement {
    let n = group.len() as f64;
    let (Some(first), true) = (group.first(), group.len() > 1) else { return group[0] };
    let t_s = group.iter().map(|pose| pose.t_s).sum::<f64>() / n;
    let middle = angles(wheels, t_s);
    let (mut position_m, mut turned_rad) = ([0.0; 2], 0.0);
    let first_rad = first.heading_rad.unwrap_or(0.0);
    for pose in group {
        let ([x_m, y_m], heading_rad) =
            (pose.position_m.unwrap_or_default(), pose.heading_rad.unwrap_or(0.0));
        let travel_m = angles(wheels, pose.t_s)
            .zip(middle)
            .map(|(from, to)| robot.wheel_radius_m * (to - from));
        let turn_rad = travel_m.difference() / robot.track_width_m;
        let (sin, cos) = (heading_rad + turn_rad / 2.0).sin_cos();
        position_m[0] += (x_m + travel_m.mean() * cos) / n;
        position_m[1] += (y_m + travel_m.mean() * sin) / n;
        turned_rad += wrap(heading_rad + turn_rad - first_rad) / n;
    }
    PoseMeasurement { t_s, position_m: Some(position_m), heading_rad: Some(first_rad + turned_rad) }
}

/// Wheel angles at a time, between two samples \[rad\].
fn angles(wheels: &[WheelSample], t_s: f64) -> WheelPair<f64> {
    let after = wheels.partition_point(|sample| sample.t_s <= t_s).clamp(1, wheels.len() - 1);
    let (a, b) = (&wheels[after - 1], &wheels[after]);
    let share = ((t_s - a.t_s) / (b.t_s - a.t_s)).clamp(0.0, 1.0);
    a.phi_rad.zip(b.phi_rad).map(|(a, b)| a + (b - a) * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::synthetic::{ROBOT, campaign, full_plan};

    fn dense() -> Recording {
        // Ten times as dense: every sample and pose repeated in time by interpolation.
        let run = campaign(&full_plan(), &[], 3).runs.swap_remove(4);
        let wheels: Vec<WheelSample> = run
            .wheels
            .windows(2)
            .flat_map(|pair| {
                (0..4).map(|k| {
                    let share = f64::from(k) / 4.0;
                    let between = |a: f64, b: f64| a + (b - a) * share;
                    WheelSample {
                        t_s: between(pair[0].t_s, pair[1].t_s),
                        phi_rad: pair[0].phi_rad.zip(pair[1].phi_rad).map(|(a, b)| between(a, b)),
                    }
                })
            })
            .collect();
        Recording { wheels, ..run }
    }

    #[test]
    fn travel_and_end_poses_stay_as_they_are() {
        let run = dense();
        let (lighter, _) = condensed(&ROBOT, &run, (WheelSamples::AtPoses, POSES_S));
        assert!(2 * lighter.wheels.len() < run.wheels.len());
        assert_eq!(lighter.wheels.first(), run.wheels.first());
        assert_eq!(lighter.wheels.last(), run.wheels.last());
        assert_eq!(lighter.measured_poses.first(), run.measured_poses.first());
        assert_eq!(lighter.measured_poses.last(), run.measured_poses.last());
    }

    #[test]
    fn of_very_many_poses_more_become_one() {
        let pose = |k: usize| PoseMeasurement {
            t_s: 0.05 * k as f64,
            position_m: Some([0.0; 2]),
            heading_rad: Some(0.0),
        };
        let run = |poses: usize| Recording {
            measured_poses: (0..poses).map(pose).collect(),
            ..Recording::default()
        };
        let within_s =
            |poses: usize| poses_within_s([&run(poses); 3].into_iter(), WheelSamples::AtPoses);
        // Two of these become one in any case.
        let most = 2 * POSES_MANY / 3;
        assert_eq!((within_s(most - 10), within_s(most + 10)), (POSES_S, 2.0 * POSES_S));
    }

    #[test]
    fn poses_of_a_turning_robot_are_averaged_where_it_was_and_noise_falls_by_the_root_of_their_number()
     {
        // On a circle of 0.3 m, a turn in eight seconds; poses every 10 ms with a millimetre of ripple.
        let (radius_m, rate) = (0.3, core::f64::consts::TAU / 8.0);
        let wheel = |t_s: f64, side: f64| {
            rate * t_s * (radius_m + side * ROBOT.track_width_m / 2.0) / ROBOT.wheel_radius_m
        };
        let at = |t_s: f64| (radius_m * (rate * t_s).sin(), radius_m * (1.0 - (rate * t_s).cos()));
        let wheels: Vec<WheelSample> = (0..=800)
            .map(|k| {
                let t_s = f64::from(k) * 0.01;
                WheelSample { t_s, phi_rad: WheelPair::new(wheel(t_s, -1.0), wheel(t_s, 1.0)) }
            })
            .collect();
        let poses = (0..=800).map(|k| {
            let t_s = f64::from(k) * 0.01;
            let ripple_m = if k % 2 == 0 { 1e-3 } else { -1e-3 };
            let (x_m, y_m) = at(t_s);
            PoseMeasurement {
                t_s,
                position_m: Some([x_m + ripple_m, y_m]),
                heading_rad: Some(rate * t_s),
            }
        });
        let run = Recording { wheels, measured_poses: poses.collect(), ..Recording::default() };
        let (lighter, many) = condensed(&ROBOT, &run, (WheelSamples::AtPoses, POSES_S));
        assert!((8.0..11.0).contains(&many), "{many}");
        let inner = &lighter.measured_poses[1..lighter.measured_poses.len() - 1];
        for pose in inner {
            let ((x_m, y_m), [seen_x, seen_y]) = (at(pose.t_s), pose.position_m.unwrap());
            assert!((seen_x - x_m).abs() < 1.5e-4 && (seen_y - y_m).abs() < 1e-5, "{pose:?}");
            assert!(wrap(pose.heading_rad.unwrap() - rate * pose.t_s).abs() < 1e-9);
        }
    }
}
