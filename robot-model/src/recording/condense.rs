//! Dense recordings, made lighter before anything is fitted: wheels some twenty times a second, and poses averaged over
//! a tenth of a second.
//!
//! Nothing is lost that a fit could use. Wheel angles are absolute: fewer samples of them are the same travel, as long
//! as there is one wherever a pose is measured: with an even speed within 60 ms, a robot that accelerates by 0.6 m/s^2
//! would be a quarter of a millimetre off in their middle, too far on while it accelerates and too far back while it
//! brakes, as by backlash. Poses close together are first moved to one time by the wheels, then averaged: white noise
//! falls by the root of their number, as it would in a fit to each of them.

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

/// A recording with fewer samples, and how many poses became one, in the mean.
pub(crate) fn condensed(robot: &Robot, recording: &Recording) -> (Recording, f64) {
    let groups = groups(&recording.measured_poses);
    let poses: Vec<PoseMeasurement> =
        groups.iter().map(|group| mean(robot, recording, group)).collect();
    let many = recording.measured_poses.len() as f64 / poses.len().max(1) as f64;
    let wheels = thinned(recording, &poses);
    (Recording { wheels, measured_poses: poses, ..recording.clone() }, many)
}

/// The first and last sample, one at each pose, and those between that are far enough apart; all where all are.
fn thinned(recording: &Recording, poses: &[PoseMeasurement]) -> Vec<WheelSample> {
    let steps = recording.wheels.len() - 1;
    if recording.duration_s() >= WHEELS_S * steps as f64 {
        return recording.wheels.clone();
    }
    let (first, last) = (recording.wheels[0], recording.wheels[steps]);
    let within = first.t_s + SAME_S..last.t_s - SAME_S;
    let poses_s = poses.iter().map(|pose| pose.t_s).filter(|t_s| within.contains(t_s));
    let mut samples = recording.wheels[1..].iter().peekable();
    let mut kept = vec![first];
    let mut before_s = first.t_s;
    for t_s in poses_s.chain([last.t_s]) {
        while let Some(sample) = samples.next_if(|sample| sample.t_s <= t_s) {
            if sample.t_s - before_s >= WHEELS_S && t_s - sample.t_s >= BESIDE_POSE_S {
                kept.push(*sample);
                before_s = sample.t_s;
            }
        }
        if t_s - before_s >= SAME_S {
            kept.push(WheelSample { t_s, phi_rad: recording.phi_at(t_s) });
            before_s = t_s;
        }
    }
    kept
}

/// Consecutive poses that become one. The first and the last stay alone, as a run begins and ends at rest.
fn groups(poses: &[PoseMeasurement]) -> Vec<&[PoseMeasurement]> {
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
            || poses[k].t_s - poses[first].t_s >= POSES_S;
        if ends {
            groups.push(&poses[first..k]);
            first = k;
        }
    }
    groups
}

/// The mean of poses, each moved to the middle of their times by the wheels.
fn mean(robot: &Robot, recording: &Recording, group: &[PoseMeasurement]) -> PoseMeasurement {
    let n = group.len() as f64;
    let (Some(first), true) = (group.first(), group.len() > 1) else { return group[0] };
    let t_s = group.iter().map(|pose| pose.t_s).sum::<f64>() / n;
    let middle = recording.phi_at(t_s);
    let (mut position_m, mut turned_rad) = ([0.0; 2], 0.0);
    let first_rad = first.heading_rad.unwrap_or(0.0);
    for pose in group {
        let ([x_m, y_m], heading_rad) =
            (pose.position_m.unwrap_or_default(), pose.heading_rad.unwrap_or(0.0));
        let travel_m = recording
            .phi_at(pose.t_s)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::composition::Terms;
    use crate::estimation::predict::open_loop;
    use crate::kinematics::wheel_pair::WheelPair;
    use crate::recording::motion::Motion;
    use crate::recording::nominal_run::{Piece, Sampling, nominal_run};
    use crate::tests::synthetic::{ROBOT, campaign, full_plan, term};

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
        let (lighter, _) = condensed(&ROBOT, &run);
        assert!(2 * lighter.wheels.len() < run.wheels.len());
        assert_eq!(lighter.wheels.first(), run.wheels.first());
        assert_eq!(lighter.wheels.last(), run.wheels.last());
        assert_eq!(lighter.measured_poses.first(), run.measured_poses.first());
        assert_eq!(lighter.measured_poses.last(), run.measured_poses.last());
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
        let (lighter, many) = condensed(&ROBOT, &run);
        assert!((8.0..11.0).contains(&many), "{many}");
        let inner = &lighter.measured_poses[1..lighter.measured_poses.len() - 1];
        for pose in inner {
            let ((x_m, y_m), [seen_x, seen_y]) = (at(pose.t_s), pose.position_m.unwrap());
            assert!((seen_x - x_m).abs() < 1.5e-4 && (seen_y - y_m).abs() < 1e-5, "{pose:?}");
            assert!(wrap(pose.heading_rad.unwrap() - rate * pose.t_s).abs() < 1e-9);
        }
    }

    /// The farthest that a sound robot's condensed poses are from where its wheels predict them \[m, rad\]. It drives
    /// with 0.6 m/s^2; 50 samples of the wheels a second, and as many poses, 3 ms later and shown late by this.
    fn farthest(late_s: f64) -> (f64, f64) {
        let straight = |travel_m| Piece::Straight { travel_m, speed_mps: 0.4 };
        let arc = Piece::Arc { radius_m: 0.5, turn_rad: 2.0, speed_mps: 0.3 };
        let spin = Piece::Spin { turn_rad: 2.0, speed_mps: 0.3 };
        let pieces = [straight(0.8), spin, straight(-0.5), arc, Piece::Rest { duration_s: 0.3 }];
        let sampling = Sampling { sample_s: 1e-3, samples_per_pose: 1, accel_mps2: 0.6 };
        let mut run = nominal_run(&ROBOT, "fine", &pieces, &sampling);
        let track =
            open_loop(&Motion::new(&ROBOT, &run, None), &run.measured_poses, Terms::Fixed(&[]));
        let seen = track.measured.iter().zip(&track.predicted).map(|(at, pose)| PoseMeasurement {
            t_s: at.t_s + late_s,
            position_m: Some([pose.x_m, pose.y_m]),
            heading_rad: Some(pose.heading_rad),
        });
        run.measured_poses = seen.skip(3).step_by(20).collect();
        run.wheels = run.wheels.iter().copied().step_by(20).collect();
        let (lighter, many) = condensed(&ROBOT, &run);
        assert!(many > 4.0, "{many}");
        let terms = [term("measurement_delay", &[late_s])];
        let motion = Motion::new(&ROBOT, &lighter, None);
        let track = open_loop(&motion, &lighter.measured_poses, Terms::Fixed(&terms));
        let off = track.measured.iter().zip(&track.predicted).map(|(seen, pose)| {
            let [x_m, y_m] = seen.position_m.unwrap();
            let turned_rad = wrap(seen.heading_rad.unwrap() - pose.heading_rad);
            ((x_m - pose.x_m).hypot(y_m - pose.y_m), turned_rad.abs())
        });
        off.fold((0.0, 0.0), |(m, rad), (a, b)| (f64::max(m, a), f64::max(rad, b)))
    }

    #[test]
    fn a_robot_that_accelerates_is_where_its_wheels_say_also_between_their_samples() {
        // At an even speed within 60 ms: 0.27 mm and 1.5 mrad.
        let (m, rad) = farthest(0.0);
        assert!(m < 3e-5 && rad < 2e-4, "{m}, {rad}");
    }
}
