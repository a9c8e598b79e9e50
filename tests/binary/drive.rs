//! `beeline drive` and `beeline record` on the simulator.

use campaign::{Campaign, Warning};
use serde_json::Value;

use crate::temp_folder::TempFolder;

/// Revolutions of both wheels.
fn revolutions(arguments: &str) -> (f64, f64) {
    let value = TempFolder::new().run(&format!("drive {arguments} --json")).ok().json();
    assert_eq!(value["end"], "completed", "{value}");
    let turns = &value["wheel_revolutions"];
    let number = |value: &Value| value.as_f64().unwrap();
    (number(&turns["left"]), number(&turns["right"]))
}

/// Two counts of 900, where a wheel comes to rest.
const REST_REV: f64 = 2.5 / 900.0;

#[test]
fn straight_reverse_spin_and_arc_turn_the_wheels_as_told() {
    let track_per_wheel = 0.372 / 0.036 / 2.0;
    let turn = std::f64::consts::TAU;
    for (arguments, left, right) in [
        ("straight 1rev", 1.0, 1.0),
        ("straight -1rev", -1.0, -1.0),
        ("straight 50cm", 0.5 / 0.036 / turn, 0.5 / 0.036 / turn),
        // A body that turns by theta turns each wheel by theta b / (2 R).
        ("spin 90deg", -track_per_wheel / 4.0, track_per_wheel / 4.0),
        ("spin -90deg", track_per_wheel / 4.0, -track_per_wheel / 4.0),
        ("arc 372mm 90deg", 0.5 * track_per_wheel / 2.0, 1.5 * track_per_wheel / 2.0),
        ("arc -372mm 90deg", -0.5 * track_per_wheel / 2.0, -1.5 * track_per_wheel / 2.0),
    ] {
        let (is_left, is_right) = revolutions(arguments);
        assert!((is_left - left).abs() < REST_REV, "{arguments}: left {is_left}, not {left}");
        assert!((is_right - right).abs() < REST_REV, "{arguments}: right {is_right}, not {right}");
    }
}

#[test]
fn a_motion_beyond_the_limits_is_refused_and_the_robot_stands() {
    let temp = TempFolder::new();
    for (arguments, expected) in [
        ("drive straight 1m --cruise 100m/s", "limits.speed_mps_max"),
        ("drive straight 1m --acceleration 100m/s^2", "limits.acceleration_mps2_max"),
        ("drive straight 0m", "zero"),
        ("drive straight 21km", "20 km"),
        ("drive velocity 0.2m/s --for 1e9s", "longer than a day"),
        ("drive straight 1m --cruise 0m/s", "above zero"),
        ("drive straight 1m --cruise -1m/s", "above zero"),
        ("drive straight 1m --cruise 1e-9m/s", "1000 s"),
        ("drive straight 1", "no unit"),
        ("drive straight 1kg", "not a unit"),
        ("drive spin 1m", "not a unit"),
        ("drive arc 0m 90deg", "spin"),
    ] {
        let message = temp.run(arguments).refused();
        assert!(message.contains(expected), "{arguments}: {message}");
    }
}

#[test]
fn a_drive_of_hours_is_driven_only_if_it_is_meant() {
    let temp = TempFolder::new();
    for arguments in ["drive straight 1m", "record new spin 1rev", "calibrate --distance 1m"] {
        let message = temp.run(&format!("{arguments} --cruise 0.0001m/s")).refused();
        assert!(message.contains("this drive takes 2 h 47 min") || message.contains("3 h 15 min"));
        assert!(message.contains("--long") && !message.contains("Driving"), "{message}");
    }
    assert_eq!(temp.listing(), [""; 0]);
    // 11 minutes.
    temp.run("drive straight 66cm --cruise 1mm/s --long").ok();
}

#[test]
fn nobody_says_driving_before_the_limits_are_kept() {
    let temp = TempFolder::new();
    for (arguments, expected) in [
        ("calibrate --cruise 100m/s", "limits.speed_mps_max"),
        ("calibrate --acceleration 100m/s^2", "limits.acceleration_mps2_max"),
        ("calibrate --method umbmark --cruise 100m/s", "limits.speed_mps_max"),
        ("calibrate --distance 1km", "at most 19.4 m with a track of 37.2 cm"),
        ("calibrate --distance 1mm", "one encoder count"),
        ("calibrate --method umbmark --side 10cm", "smaller than the robot"),
        ("calibrate --distance 19.5m", "too far to determine W_T"),
        ("calibrate --out-and-back --runs 4", "begins where the way out ended"),
        ("calibrate --out-and-back --method umbmark", "belongs to --method straight"),
        ("record new straight 1m --cruise 100m/s", "limits.speed_mps_max"),
    ] {
        let message = temp.run(arguments).refused();
        assert!(message.contains(expected), "{arguments}: {message}");
        assert!(!message.contains("Driving") && !message.contains("UMBmark of"), "{message}");
    }
    assert_eq!(temp.listing(), [""; 0]);
    temp.run("calibrate --distance 19.4m").ok();
}

#[test]
fn recorded_runs_are_numbered_and_read_back() {
    let temp = TempFolder::new();
    let first = temp.run("record robot straight 1rev --json").ok().json();
    assert_eq!(first["run"], "robot/runs/01_straight.csv");
    temp.run("record robot straight 1rev").ok();
    temp.run("record robot --name turn_left spin 45deg --rate 50").ok();

    let campaign = Campaign::read(&temp.path("robot")).unwrap();
    let names: Vec<_> = campaign.runs.iter().map(|run| run.name.as_str()).collect();
    assert_eq!(names, ["01_straight", "02_straight", "03_turn_left"]);
    // None of them has a start time; there is no other warning.
    let [Warning::NoStart { runs: 3, of: 3, .. }] = campaign.warnings[..] else {
        panic!("{:?}", campaign.warnings);
    };
    assert_eq!(campaign.robot.wheel_radius_m, 0.036);
    assert_eq!(first["samples"].as_u64(), Some(campaign.runs[0].rows.len() as u64));
    for run in &campaign.runs {
        assert_eq!(run.facts.started_s, None, "each is a new robot, with a clock of its own");
        assert!(run.rows.iter().any(|row| row.x_m.is_some()), "{} has poses", run.name);
    }
    let counts: Vec<_> = campaign.runs[0].rows.iter().filter_map(|row| row.counts.left).collect();
    let travelled = counts.last().unwrap() - counts[0];
    assert!((travelled / 900.0 - 1.0).abs() < REST_REV, "{travelled} counts");
}

#[test]
fn the_same_seed_records_the_same_bytes_and_another_seed_others() {
    let temp = TempFolder::new();
    for (folder, seed) in [("a", 3), ("b", 3), ("c", 4)] {
        temp.run(&format!("record {folder} arc 50cm 30deg --seed {seed}")).ok();
    }
    let run = |folder: &str| temp.read(&format!("{folder}/runs/01_arc.csv"));
    assert!(run("a") == run("b"));
    assert!(run("a") != run("c"));
    assert!(temp.read("a/robot.toml") == temp.read("b/robot.toml"));
}

#[test]
fn a_run_that_cannot_be_recorded_is_not_driven() {
    let temp = TempFolder::new();
    temp.write("file", "");
    temp.run("record good straight 10cm").ok();
    let robot = temp.read("good/robot.toml");
    for arguments in [
        "record /proc/campaign straight 1rev",
        "record file straight 1rev",
        "record new arc 0m 90deg",
        "record good --name a/b straight 1rev",
        "record good --name ../b straight 1rev",
        "record good --rate 0 straight 1rev",
    ] {
        temp.run(arguments).refused();
    }
    assert_eq!(temp.listing(), ["file", "good"]);
    assert_eq!(temp.read("good/robot.toml"), robot);
    let runs = std::fs::read_dir(temp.path("good/runs")).unwrap().count();
    assert_eq!(runs, 1, "no half-written run");
}

#[test]
fn a_run_that_ends_in_a_fault_is_kept_as_far_as_it_came() {
    let temp = TempFolder::new();
    temp.write(
        "blocked.toml",
        "name = \"blocked\"\n[[fault]]\nkind = \"wheel_blocked\"\nwheel = \"left\"\nat_motion_s = 3.0\n",
    );
    let message = temp.run("record robot straight 4rev --port sim:blocked.toml").refused();
    assert!(message.contains("stopped with a fault"), "{message}");
    assert!(message.contains("left"), "{message}");
    let campaign = Campaign::read(&temp.path("robot")).unwrap();
    assert_eq!(campaign.runs.len(), 1);
    let counts: Vec<_> = campaign.runs[0].rows.iter().filter_map(|row| row.counts.right).collect();
    assert!(counts.last().unwrap() - counts[0] > 100.0, "it drove until the wheel was blocked");
}
