//! Logs as people have them: what is certain is mended and said, what may be either of two things is asked.

use std::f64::consts::TAU;

use import::log::{Pose3, PoseLog, WheelLog};
use import::understand::{Hints, Understood, understand};
use robot_model::recording::Recording;

use crate::hints;

/// The nominal robot \[m\].
const RADIUS_M: f64 = 0.036;
const WIDTH_M: f64 = 0.372;

/// Moves: travel \[m/s\], turn \[rad/s\], time \[s\], each followed by a stop. They repeat themselves.
const MOVES: [[f64; 3]; 5] =
    [[0.3, 0.0, 5.0], [0.0, 1.0, 5.0], [-0.3, 0.0, 4.0], [0.25, 0.6, 6.0], [0.0, -1.0, 5.5]];

/// Wheels in radians and poses, both at 50 Hz, of a robot whose right wheel is 0.6 % too large.
pub fn drive() -> (WheelLog, PoseLog) {
    drive_of(&MOVES, 2.6)
}

/// The same with other moves, and stops that take so long and longer \[s\].
fn drive_of(moves: &[[f64; 3]], stop_s: f64) -> (WheelLog, PoseLog) {
    long_drive(moves, stop_s, 15)
}

/// So many moves, again and again.
fn long_drive(moves: &[[f64; 3]], stop_s: f64, count: usize) -> (WheelLog, PoseLog) {
    const STEP_S: f64 = 0.02;
    let (mut wheels, mut poses) = (WheelLog::default(), PoseLog::default());
    let ([mut x_m, mut y_m], mut heading_rad, mut turned) = ([0.0; 2], 0.0_f64, [0.0; 2]);
    for (number, [travel, turn, time_s]) in moves.iter().cycle().take(count).enumerate() {
        let stop_s = stop_s + 0.13 * (number % 5) as f64;
        for step in 0..((time_s + stop_s) / STEP_S) as usize {
            let at_s = step as f64 * STEP_S;
            let share = (at_s.min(time_s - at_s) / 0.5).clamp(0.0, 1.0);
            let apart = share * turn * WIDTH_M / 2.0;
            let rolled_m = [share * travel - apart, share * travel + apart].map(|v| v * STEP_S);
            turned = [0, 1].map(|side: usize| turned[side] + rolled_m[side] / RADIUS_M);
            let (left_m, right_m) = (rolled_m[0], 1.006 * rolled_m[1]);
            let middle_rad = heading_rad + (right_m - left_m) / WIDTH_M / 2.0;
            heading_rad += (right_m - left_m) / WIDTH_M;
            x_m += (left_m + right_m) / 2.0 * middle_rad.cos();
            y_m += (left_m + right_m) / 2.0 * middle_rad.sin();
            let t_s = 1e9 + wheels.t_s.len() as f64 * STEP_S;
            wheels.t_s.push(t_s);
            wheels.turned.push(turned);
            let (sin, cos) = (heading_rad / 2.0).sin_cos();
            // A tracker is never the same twice.
            let noise_m = 3e-4 * (7.7 * t_s).sin();
            let position_m = [x_m + noise_m, y_m - noise_m, 0.1];
            poses.poses.push(Pose3 { t_s, position_m, orientation: Some([0.0, 0.0, sin, cos]) });
        }
    }
    (wheels, poses)
}

pub fn of_one_clock(wheels: WheelLog, poses: &PoseLog) -> Understood {
    understand(wheels, poses, &hints(), true).unwrap_or_else(|error| panic!("{error}"))
}

fn notes(understood: &Understood) -> String {
    understood.notes.iter().map(|note| note.text.as_str()).collect::<Vec<_>>().join("\n")
}

/// All runs but those that are left out, at most so many, on one clock; the wheels end where they did.
fn check(understood: &Understood, left_out_max: usize) {
    assert!(understood.clock.late_s.abs() < 1e-3, "{:?}", understood.clock);
    assert!(understood.left_out.len() <= left_out_max, "{:?}", understood.left_out);
    assert_eq!(understood.runs.len() + understood.left_out.len(), 15);
    let first = &understood.runs[0].recording;
    let rolled_rad = first.wheels[first.wheels.len() - 1].phi_rad;
    let from_rad = first.wheels[0].phi_rad;
    for (to, from) in [(rolled_rad.left, from_rad.left), (rolled_rad.right, from_rad.right)] {
        assert!((to - from - 4.5 * 0.3 / RADIUS_M).abs() < 0.5, "{}", to - from);
    }
}

/// What the wheels do not show, the poses show as noise alone.
#[test]
fn a_robot_that_only_goes_straight_or_only_spins_is_understood() {
    let straights = [[0.3, 0.0, 5.0], [-0.3, 0.0, 5.0], [0.2, 0.0, 4.0], [-0.2, 0.0, 4.0]];
    let spins = [[0.0, 1.0, 5.0], [0.0, -1.0, 5.5], [0.0, 0.6, 6.0]];
    for moves in [&straights[..], &spins] {
        let (wheels, poses) = drive_of(moves, 2.6);
        let understood = of_one_clock(wheels.clone(), &poses);
        assert_eq!((understood.runs.len(), understood.left_out.len()), (15, 0));
        assert!(understood.clock.late_s.abs() < 1e-3, "{:?}", understood.clock);
        // What nobody can know is asked.
        let is_straight = moves.len() == straights.len();
        let [known, asked] = match is_straight {
            true => [Hints { track_width_m: None, ..hints() }, hints()],
            false => [Hints { wheel_radius_m: None, ..hints() }, hints()],
        };
        let refused = understand(wheels.clone(), &poses, &known, true).unwrap_err().to_string();
        let option = if is_straight { "add --track-width" } else { "add --wheel-radius" };
        assert!(refused.contains(option), "{refused}");
        assert!(understand(wheels, &poses, &asked, true).is_ok());
    }
}

/// Before they are converted, positions in millimetres move by hundreds while the robot stands.
#[test]
fn a_robot_whose_positions_are_in_millimetres_is_not_carried() {
    let (wheels, mut poses) = drive_of(&MOVES, 1.2);
    let metres = of_one_clock(wheels.clone(), &poses);
    for pose in &mut poses.poses {
        pose.position_m = pose.position_m.map(|m| 1000.0 * m);
    }
    let understood = of_one_clock(wheels, &poses);
    let begins = |of: &Understood| of.runs.iter().map(|run| run.begins).collect::<Vec<_>>();
    assert_eq!(begins(&understood), begins(&metres));
    assert!(notes(&understood).contains("1000"), "{}", notes(&understood));
}

#[test]
fn a_tracker_whose_axes_lie_askew_to_the_floor_gives_the_same_runs() {
    let (wheels, mut poses) = drive();
    let level = of_one_clock(wheels.clone(), &poses);
    let (sin, cos) = 0.35_f64.sin_cos();
    let (half_sin, half_cos) = 0.175_f64.sin_cos();
    for pose in &mut poses.poses {
        let [x, y, z] = pose.position_m;
        pose.position_m = [x, cos * y - sin * z, sin * y + cos * z];
        let [_, _, qz, qw] = pose.orientation.unwrap();
        pose.orientation = Some([half_sin * qw, -half_sin * qz, half_cos * qz, half_cos * qw]);
    }
    let understood = of_one_clock(wheels, &poses);
    assert!(notes(&understood).contains("by 20.1 degrees: levelled"), "{}", notes(&understood));
    for (a, b) in level.runs.iter().zip(&understood.runs) {
        let apart = |run: &import::understand::RunUnderstood| {
            let poses = &run.recording.measured_poses;
            let [a, b] = [0, poses.len() / 2].map(|k| poses[k].position_m.unwrap());
            (a[0] - b[0]).hypot(a[1] - b[1])
        };
        assert!((apart(a) - apart(b)).abs() < 2e-4, "{} {}", apart(a), apart(b));
    }
}

/// Half an hour of one robot, and the poses of another one: at some lag a part of both looks alike.
#[test]
fn poses_of_another_drive_are_no_poses_of_this_one() {
    let (wheels, _) = drive();
    let others = [
        [[0.0, 0.7, 6.0], [0.2, 0.0, 3.0], [0.3, -0.5, 4.0]],
        [[0.3, 0.0, 2.0], [0.3, 0.4, 7.0], [0.0, -1.2, 4.0]],
        [[-0.2, 0.0, 7.0], [0.0, -0.9, 3.0], [0.15, 0.9, 5.0]],
    ];
    for moves in others {
        let (_, poses) = drive_of(&moves, 3.1);
        let told = understand(wheels.clone(), &poses, &hints(), true);
        assert!(told.is_err(), "{:?}", told.map(|told| told.clock));
    }
}

#[test]
fn a_tracker_that_freezes_and_drops_out_does_not_move_the_clock_to_where_the_drive_repeats_itself()
{
    let (wheels, mut poses) = drive();
    let begin_s = wheels.t_s[0];
    let frozen = poses.poses.iter().find(|pose| pose.t_s > begin_s + 10.0).copied().unwrap();
    for pose in &mut poses.poses {
        if (10.0..16.0).contains(&(pose.t_s - begin_s)) {
            *pose = Pose3 { t_s: pose.t_s, ..frozen };
        }
    }
    poses.poses.retain(|pose| !(50.0..53.0).contains(&(pose.t_s - begin_s)));
    check(&of_one_clock(wheels, &poses), 3);
}

#[test]
fn a_counter_that_restarts_costs_one_run_and_not_the_clock() {
    let (mut wheels, poses) = drive();
    let from = 600;
    let zero = wheels.turned[from];
    for turned in &mut wheels.turned[from..] {
        *turned = [0, 1].map(|side| turned[side] - zero[side]);
    }
    check(&of_one_clock(wheels, &poses), 1);
}

#[test]
fn a_wheel_that_counts_backwards_is_found_though_going_looks_like_turning() {
    for side in 0..2 {
        let (mut wheels, poses) = drive();
        wheels.turned.iter_mut().for_each(|turned| turned[side] = -turned[side]);
        let understood = of_one_clock(wheels, &poses);
        check(&understood, 0);
        let name = ["left", "right"][side];
        assert!(notes(&understood).contains(&format!("the {name} wheel counts backwards")));
    }
}

/// Whether poses turn and go as the wheels do, to what a wheel that is 0.6 % too large makes of it.
fn goes_as_its_wheels(run: &Recording) {
    let [first, last] = [0, run.wheels.len() - 1].map(|sample| run.wheels[sample].phi_rad);
    let [left_m, right_m] =
        [last.left - first.left, last.right - first.right].map(|rad| rad * RADIUS_M);
    let [from, to] = [0, run.measured_poses.len() - 1].map(|pose| run.measured_poses[pose]);
    let [from_rad, to_rad] = [from, to].map(|pose| pose.heading_rad.unwrap());
    let may_rad = 0.01 + 0.006 * left_m.abs().max(right_m.abs()) / WIDTH_M;
    let off_rad = to_rad - from_rad - (right_m - left_m) / WIDTH_M;
    assert!(off_rad.abs() < may_rad, "{}: {off_rad}", run.name);
    // Along the direction in its middle, as each run is a straight, an arc or a spin.
    let [[x, y], [to_x, to_y]] = [from, to].map(|pose| pose.position_m.unwrap());
    let (sin, cos) = ((from_rad + to_rad) / 2.0).sin_cos();
    let half_rad = (to_rad - from_rad) / 2.0;
    let chord_m = (left_m + right_m) / 2.0 * half_rad.sin() / half_rad;
    let along_m = cos * (to_x - x) + sin * (to_y - y);
    assert!((along_m - chord_m).abs() < 0.02, "{}: {along_m} m of {chord_m} m", run.name);
}

/// Right of them is what can be right: which wheel is larger depends on which is which, and the doubt is told.
#[test]
fn exchanged_wheels_of_which_one_counts_backwards_are_understood() {
    let (wheels, poses) = drive();
    for side in 0..2 {
        let mut wrong = wheels.clone();
        for turned in &mut wrong.turned {
            turned.reverse();
            turned[side] = -turned[side];
        }
        let understood = of_one_clock(wrong, &poses);
        let said = notes(&understood);
        assert!(said.contains("if they are, import again with the wheels exchanged"), "{said}");
        assert_eq!((understood.runs.len(), understood.left_out.len()), (15, 0));
        for run in &understood.runs {
            goes_as_its_wheels(&run.recording);
        }
    }
}

#[test]
fn a_marker_that_is_often_seen_back_to_front_is_no_other_robot() {
    let (wheels, poses) = drive();
    let mut wild = poses.clone();
    let turn = |pose: &mut Pose3| {
        pose.orientation = pose.orientation.map(|[x, y, sin, cos]| [x, y, cos, -sin]);
    };
    // One or three frames of twenty.
    for (k, pose) in wild.poses.iter_mut().enumerate() {
        if k % 20 == 7 || k % 60 < 3 {
            turn(pose);
        }
    }
    let understood = of_one_clock(wheels, &wild);
    assert!(notes(&understood).contains("back to front: left out"), "{}", notes(&understood));
    check(&understood, 0);
}

/// Not a tracker whose axes are mirrored, with a marker back to front.
#[test]
fn both_wheels_may_count_backwards() {
    let (wheels, poses) = drive();
    let as_it_is = of_one_clock(wheels.clone(), &poses);
    let mut backwards = wheels.clone();
    backwards.turned.iter_mut().flatten().for_each(|turned| *turned = -*turned);
    let understood = of_one_clock(backwards, &poses);
    assert!(notes(&understood).contains("both wheels count backwards"), "{}", notes(&understood));
    for (a, b) in as_it_is.runs.iter().zip(&understood.runs) {
        assert_eq!((&a.name, &a.recording.measured_poses), (&b.name, &b.recording.measured_poses));
        assert_eq!(a.recording.wheels.len(), b.recording.wheels.len());
    }
    // A marker that sits back to front alone is one.
    let mut turned = poses.clone();
    for pose in &mut turned.poses {
        pose.orientation = pose.orientation.map(|[x, y, sin, cos]| [x, y, cos, -sin]);
    }
    let understood = of_one_clock(wheels, &turned);
    assert!(notes(&understood).contains("headings are turned by"), "{}", notes(&understood));
    assert!(!notes(&understood).contains("both wheels"), "{}", notes(&understood));
}

#[test]
fn single_poses_elsewhere_or_back_to_front_are_left_out_and_said() {
    let (wheels, poses) = drive();
    let as_it_is = of_one_clock(wheels.clone(), &poses);
    let mut wild = poses.clone();
    for (k, pose) in wild.poses.iter_mut().enumerate() {
        match k % 301 {
            100 => pose.position_m[0] += 0.5,
            // Two frames, to one place.
            200 | 201 => pose.position_m[1] -= 0.06,
            // About z by half a turn.
            250 => pose.orientation = pose.orientation.map(|[x, y, sin, cos]| [x, y, cos, -sin]),
            _ => {}
        }
    }
    let understood = of_one_clock(wheels, &wild);
    let said = notes(&understood);
    assert!(
        said.contains("poses are outliers, far from those before and after: left out"),
        "{said}"
    );
    assert_eq!(understood.runs.len(), as_it_is.runs.len());
    let mut left_out = 0;
    for (a, b) in as_it_is.runs.iter().zip(&understood.runs) {
        let [sound, kept] = [a, b].map(|run| &run.recording.measured_poses);
        left_out += sound.len() - kept.len();
        // A turn more in all of a run is none.
        let whole_rad = sound[0].heading_rad.unwrap() - kept[0].heading_rad.unwrap();
        let whole_rad = TAU * (whole_rad / TAU).round();
        for pose in kept {
            let t_s = b.started_s - a.started_s + pose.t_s;
            let Some(same) = sound.iter().find(|same| (same.t_s - t_s).abs() < 1e-3) else {
                continue;
            };
            let [at, there] = [same, pose].map(|pose| pose.position_m.unwrap());
            let turned_rad = same.heading_rad.unwrap() - pose.heading_rad.unwrap() - whole_rad;
            assert!((at[0] - there[0]).hypot(at[1] - there[1]) < 1e-3, "{same:?} {pose:?}");
            assert!(turned_rad.abs() < 1e-3, "{same:?} {pose:?}");
        }
    }
    assert!(left_out > 40, "{left_out}");
}

#[test]
fn wheels_in_degrees_turns_or_metres_are_converted_by_the_radius() {
    for (name, unit) in
        [("degrees", std::f64::consts::PI / 180.0), ("turns", TAU), ("metres", 1.0 / RADIUS_M)]
    {
        let (mut wheels, poses) = drive();
        wheels.turned.iter_mut().flatten().for_each(|number| *number /= unit);
        let understood = of_one_clock(wheels, &poses);
        check(&understood, 0);
        assert!(notes(&understood).contains(&format!("are in {name}, not in radians")));
    }
}

#[test]
fn wheels_of_two_robots_in_one_topic_are_an_error() {
    let (mut wheels, poses) = drive();
    wheels.turned.iter_mut().skip(1).step_by(2).for_each(|turned| *turned = [40.0, 70.0]);
    let error = understand(wheels, &poses, &hints(), true).unwrap_err().to_string();
    assert!(error.contains("goes to and fro from sample to sample, as of two robots"), "{error}");
}

#[test]
fn a_robot_that_is_carried_as_far_as_it_drives_has_the_same_clock() {
    let (wheels, mut poses) = drive();
    let (mut still_s, mut carried_m) = (0.0_f64, 0.0);
    for k in 1..poses.poses.len() {
        let stands = wheels.turned[k] == wheels.turned[k - 1];
        still_s = if stands { still_s + 0.02 } else { 0.0 };
        // Half a metre in each stop, faster than it drives.
        let speed_mps = 0.5 * ((still_s.min(2.3 - still_s) - 0.5_f64) / 0.2).clamp(0.0, 1.0);
        carried_m += speed_mps * 0.02;
        poses.poses[k].position_m[1] += carried_m;
    }
    check(&of_one_clock(wheels, &poses), 0);
}

#[test]
fn poses_of_another_drive_with_the_same_motions_are_an_error() {
    let (wheels, mut poses) = drive();
    let end_s = wheels.t_s[0] + wheels.t_s[wheels.t_s.len() - 1];
    poses.poses.iter_mut().for_each(|pose| pose.t_s = end_s - pose.t_s);
    poses.poses.reverse();
    let error = understand(wheels, &poses, &hints(), true).unwrap_err().to_string();
    assert!(error.contains("no motion in common") || error.contains("repeats itself"), "{error}");
}

/// An hour of a drive that repeats itself is cut into the same runs, and a controller's clock may have no crystal.
#[test]
fn clocks_may_drift_apart_by_more_than_a_drive_takes_to_repeat_itself() {
    for (count, ppm) in
        [(8, 5000.0), (15, 12_000.0), (15, 0.0), (80, -5000.0), (400, 200.0), (400, 2000.0)]
    {
        let (wheels, mut poses) = long_drive(&MOVES, 2.6, count);
        let (begin_s, end_s) = (wheels.t_s[0], wheels.t_s[wheels.t_s.len() - 1]);
        for pose in &mut poses.poses {
            pose.t_s = begin_s + 17.0 + (pose.t_s - begin_s) * (1.0 + 1e-6 * ppm);
        }
        let understood = understand(wheels, &poses, &hints(), false)
            .unwrap_or_else(|error| panic!("{count} runs, {ppm} ppm: {error}"));
        assert_eq!((understood.runs.len(), understood.left_out.len()), (count, 0));
        // At either end of the log.
        let off_s = (understood.clock.rate() - 1e-6 * ppm) * (end_s - begin_s) / 2.0;
        assert!(off_s.abs() < 5e-3, "{count} runs, {ppm} ppm: {:?}", understood.clock);
        for run in [0, count / 2, count - 1].map(|run| &understood.runs[run].recording) {
            goes_as_its_wheels(run);
        }
    }
}
