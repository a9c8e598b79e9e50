//! Are wrong last poses found, and those of inaccurate robots not taken for them?

use super::mismatch::sound;
use crate::checks::{end_pose_misfits, end_poses_off, implausible_end_pose, median_pose_error};
use crate::kinematics::Pose;
use crate::recording::{PoseMeasurement, Recording, Robot};
use crate::tests::synthetic::{ALONE, ROBOT, campaign, full_plan, term};

#[test]
fn a_robot_that_is_merely_inaccurate_has_no_poses_that_are_off() {
    let none = |runs: &[Recording], what: &str| {
        assert_eq!(end_poses_off(&ROBOT, runs), vec![None; runs.len()], "{what}");
        assert_eq!(runs.iter().find_map(|run| median_pose_error(&ROBOT, run)), None, "{what}");
    };
    for ends_only in [false, true] {
        none(&sound(ends_only).runs, "sound");
    }
    for (id, values) in ALONE {
        none(&campaign(&full_plan(), &[term(id, values)], 3).runs, id);
    }
}

#[test]
fn a_misread_pose_is_found() {
    let near = |found: Option<f64>, off: f64| match found {
        Some(found) => (found - off).abs() < 0.05,
        None => off == 0.0,
    };
    for ends_only in [false, true] {
        for (name, off_m, off_rad) in [
            ("arc", 0.0, 1.57),
            ("out_and_back", 1.0, 0.0),
            ("spin", 0.0, 1.57),
            ("spin", 0.0, -1.57),
        ] {
            let mut runs = sound(ends_only).runs;
            let index = runs.iter().position(|run| run.name.starts_with(name)).unwrap();
            let last = runs[index].measured_poses.last_mut().unwrap();
            last.heading_rad = last.heading_rad.map(|rad| rad + off_rad);
            last.position_m = last.position_m.map(|[x, y]| [x, y + off_m]);
            let t_s = last.t_s;
            let mut found = end_poses_off(&ROBOT, &runs);
            let pose = found[index].take().unwrap_or_else(|| panic!("{name}, {ends_only}"));
            assert_eq!(pose.t_s, t_s);
            assert!(near(pose.position_m, off_m) && near(pose.heading_rad, off_rad), "{pose:?}");
            assert_eq!(found, vec![None; runs.len()], "{name}, {ends_only}");
        }
    }
}

#[test]
fn mirrored_poses_are_found_even_if_the_run_ends_where_it_began() {
    for run in sound(false).runs.iter().filter(|run| run.name.starts_with("arc")) {
        let mut mirrored = run.clone();
        for measurement in &mut mirrored.measured_poses {
            measurement.position_m = measurement.position_m.map(|[x, y]| [x, -y]);
        }
        assert!(
            median_pose_error(&ROBOT, &mirrored).is_some_and(|distance_m| distance_m > 0.3),
            "{}",
            run.name
        );
    }
}

#[test]
fn a_wrong_track_width_makes_no_end_pose_wrong_and_hides_none() {
    let robot = Robot { track_width_m: 1.12 * ROBOT.track_width_m, ..ROBOT };
    let mut runs = sound(true).runs;
    assert_eq!(end_poses_off(&robot, &runs), vec![None; runs.len()]);
    let index = runs.iter().position(|run| run.name.starts_with("spin")).unwrap();
    let last = runs[index].measured_poses.last_mut().unwrap();
    last.heading_rad = last.heading_rad.map(|rad| rad + 1.57);
    let found = end_poses_off(&robot, &runs);
    assert!(found[index].is_some() && found.iter().flatten().count() == 1, "{found:?}");
}

#[test]
fn a_reading_is_doubtful_if_the_wheels_led_elsewhere() {
    let at = |t_s: f64, x_m: f64, heading_rad: Option<f64>| PoseMeasurement {
        t_s,
        position_m: Some([x_m, 0.0]),
        heading_rad,
    };
    let ahead: Vec<Pose> = (0..=18).map(|k| Pose::new(0.1 * f64::from(k), 0.0, 0.0)).collect();
    let spin: Vec<Pose> = (0..=18).map(|k| Pose::new(0.0, 0.0, 0.7 * f64::from(k))).collect();
    let turned_rad = Some(0.7 * 18.0);
    let start = at(0.0, 0.0, Some(0.0));
    for (wheels, good, bad) in [
        (&ahead, at(9.0, 1.75, Some(0.1)), at(9.0, 1.2, Some(0.1))),
        (&ahead, at(9.0, 1.75, None), at(9.0, 1.75, Some(1.57))),
        (&spin, at(9.0, 0.02, turned_rad), at(9.0, 0.02, turned_rad.map(|rad| rad + 1.57))),
        (&spin, at(9.0, 0.02, None), at(9.0, 0.3, None)),
    ] {
        assert_eq!(implausible_end_pose(&start, &good, wheels), None);
        assert!(implausible_end_pose(&start, &bad, wheels).is_some(), "{bad:?}");
    }
}

#[test]
fn an_end_pose_that_is_misread_by_a_little_is_an_outlier_among_others_that_agree() {
    for (name, off_m, off_rad) in
        [("arc", 0.0, 0.2), ("arc", 0.3, 0.0), ("out_and_back", 0.2, 0.0), ("spin", 0.0, -0.3)]
    {
        let mut runs = sound(true).runs;
        let index = runs.iter().position(|run| run.name.starts_with(name)).unwrap();
        let last = runs[index].measured_poses.last_mut().unwrap();
        last.heading_rad = last.heading_rad.map(|rad| rad + off_rad);
        last.position_m = last.position_m.map(|[x, y]| [x, y + off_m]);
        let found = end_poses_off(&ROBOT, &runs);
        assert!(found[index].is_some(), "{name}: {found:?}");
        assert_eq!(found.iter().flatten().count(), 1, "{name}: {found:?}");
        // A run with a load may well differ from all others.
        runs[index].payload_kg = 2.0;
        assert_eq!(end_poses_off(&ROBOT, &runs), vec![None; runs.len()], "{name}");
    }
}

#[test]
fn misfits_are_small_in_the_right_axes_and_large_in_others() {
    let runs = sound(true).runs;
    let misfit =
        |robot: &Robot, runs: &[Recording]| end_pose_misfits(robot, runs).iter().sum::<f64>();
    let here = misfit(&ROBOT, &runs);
    let mirrored: Vec<Recording> = runs
        .iter()
        .map(|run| {
            let mut run = run.clone();
            for pose in &mut run.measured_poses {
                pose.position_m = pose.position_m.map(|[x, y]| [x, -y]);
            }
            run
        })
        .collect();
    let there = misfit(&ROBOT, &mirrored);
    assert!(here < 0.2 && there > 5.0 * here, "{here}, {there}");
    // An inaccurate geometry is fitted.
    let robot = Robot { wheel_radius_m: 1.05 * ROBOT.wheel_radius_m, ..ROBOT };
    let other = misfit(&robot, &runs);
    assert!(other < 0.2, "{other}");
}
