//! `beeline import` and `export`: one log of a whole campaign, as other programs write it, gives the same answer as the
//! campaign itself; what cannot be imported is one error, and no folder.

use std::path::Path;

use ::import::export::bag;
use ::import::geometry::Geometry;
use ::import::mcap::BagWriter;
use ::import::message::{encode_joints, encode_pose};

use crate::example::runs_of;
use crate::one_log::OneLog;
use crate::temp_folder::TempFolder;

const MYSTERY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/mystery-robot");
/// How late the poses are made \[s\].
const LATE_S: f64 = 3.72;
/// The data sheet of the mystery.
const SHEET: [&str; 4] = ["--wheel-radius", "36mm", "--track-width", "37.2cm"];
/// Its runs, but for the one in which it rests.
const RUNS: usize = 20;

fn mystery() -> OneLog {
    OneLog::of(Path::new(MYSTERY), LATE_S)
}

fn put(temp: &TempFolder, name: &str, bytes: impl AsRef<[u8]>) {
    std::fs::write(temp.path(name), bytes).unwrap();
}

/// The growth of the radius with speed that `explain` finds in a campaign, which must be all that it finds; its standard
/// error.
#[track_caller]
fn speed_growth(temp: &TempFolder, campaign: &str) -> (f64, f64) {
    let answer = temp.run_with(&["explain", campaign, "--format", "json"], "").ok().json();
    let steps = answer["steps"].as_array().unwrap();
    let effects: Vec<&str> = steps.iter().map(|step| step["effect"].as_str().unwrap()).collect();
    assert_eq!(effects, ["speed_growth"], "{answer:#}");
    let found = &steps[0]["parameters"][0];
    (found["value"].as_f64().unwrap(), found["sigma"].as_f64().unwrap())
}

/// Imports, and requires the clock to be found within 2 ms, so many runs, and the answer of the mystery itself within so
/// many of its standard errors. What was said.
#[track_caller]
fn same_answer(temp: &TempFolder, arguments: &[&str], runs: usize, sigmas: f64) -> String {
    let line = [&["import"], arguments, &["-o", "my-robot", "--json"]].concat();
    let outcome = temp.run_with(&line, "").ok();
    let told = outcome.json();
    let late_s = told["clock"]["late_s"].as_f64().unwrap();
    assert!((late_s - LATE_S).abs() < 0.002, "{late_s}");
    assert_eq!(told["runs"].as_array().unwrap().len(), runs, "{told:#}");
    let (value, _) = speed_growth(temp, "my-robot");
    let (expected, sigma) = speed_growth(temp, MYSTERY);
    assert!((value - expected).abs() < sigmas * sigma, "{value}, not {expected} ± {sigma}");
    assert!(temp.path("my-robot/import.html").exists());
    outcome.stderr
}

#[test]
fn a_data_log_of_wpilib_gives_the_answer_of_the_mystery_and_one_that_is_cut_off_is_read_as_far_as_it_goes()
 {
    let temp = TempFolder::new();
    let whole = mystery().wpilog();
    put(&temp, "drive.wpilog", &whole);
    let told = temp
        .run_with(&["import", "drive.wpilog", "-o", "none", "--map", "x_m=/nothing"], "")
        .refused();
    assert!(told.contains("no file has a column `/nothing`"), "{told}");
    assert!(told.contains("/drive/left_rad") && told.contains("/vision/pose.heading"), "{told}");
    let map = "x_m=/vision/pose.x,y_m=/vision/pose.y,heading_rad=/vision/pose.heading";
    let arguments = [&["drive.wpilog", "--map", map], &SHEET[..]].concat();
    same_answer(&temp, &arguments, RUNS, 1.0);
    put(&temp, "cut.wpilog", &whole[..whole.len() * 2 / 3 + 5]);
    let line =
        [&["import", "cut.wpilog", "-o", "cut", "--json", "--map", map], &SHEET[..]].concat();
    let cut = temp.run_with(&line, "").ok();
    assert!(cut.stderr.contains("the log is cut off after"), "{}", cut.stderr);
    let runs = cut.json()["runs"].as_array().unwrap().len();
    assert!((10..RUNS).contains(&runs), "{runs}");
}

#[test]
fn one_bag_with_the_tracker_in_its_own_frame_and_clock_gives_the_same_answer() {
    let temp = TempFolder::new();
    put(&temp, "drive.mcap", mystery().bag());
    same_answer(&temp, &[&["drive.mcap"], &SHEET[..]].concat(), RUNS, 1.0);
    // The same again changes nothing, with --add either, and draws the page that an interrupted import lacks.
    std::fs::remove_file(temp.path("my-robot/import.html")).unwrap();
    for add in [&[][..], &["--add"]] {
        let line = [&["import", "drive.mcap", "-o", "my-robot"], add].concat();
        let said = temp.run_with(&line, "").ok().stderr;
        assert!(said.contains(&format!("{RUNS} of them were there already")), "{said}");
        assert_eq!(std::fs::read_dir(temp.path("my-robot/runs")).unwrap().count(), RUNS);
        assert!(temp.path("my-robot/import.html").exists());
    }
    put(&temp, "other.mcap", OneLog::of_runs(Path::new(MYSTERY), LATE_S, 4..9).bag());
    let other = temp.run_with(&["import", "other.mcap", "-o", "my-robot"], "").refused();
    assert!(other.contains("my-robot: this campaign has runs already"), "{other}");
    std::fs::remove_file(temp.path("other.mcap")).unwrap();
    assert_eq!(temp.listing(), ["drive.mcap", "my-robot"]);
}

#[test]
fn a_table_and_a_trajectory_with_clocks_of_their_own_give_the_same_answer() {
    let temp = TempFolder::new();
    let log = mystery();
    put(&temp, "wheels.csv", log.table());
    put(&temp, "track.tum", log.trajectory());
    let map = "left_counts=enc_l,right_counts=enc_r,t_s=stamp:ns";
    let files = ["wheels.csv", "track.tum", "--map", map, "--counts-per-rev", "900"];
    same_answer(&temp, &[&files, &SHEET[..]].concat(), RUNS, 1.0);
}

/// With the controller's file, which has multipliers of its own, and by options that say the same.
#[test]
fn odometry_alone_gives_the_same_answer_and_says_what_is_lost() {
    let temp = TempFolder::new();
    let geometry = Geometry {
        radius_multipliers: [1.013, 0.991],
        separation_multiplier: 1.02,
        ..Geometry::nominal(0.036, 0.372)
    };
    put(&temp, "drive.mcap", mystery().odometry_bag(&geometry));
    let controller = "base:\n  ros__parameters:\n    wheel_radius: 0.036\n    wheel_separation: 0.372\n    \
        left_wheel_radius_multiplier: 1.013\n    right_wheel_radius_multiplier: 0.991\n    wheel_separation_multiplier: 1.02\n";
    temp.write("controller.yaml", controller);
    let refused = temp.run("import drive.mcap -o my-robot").refused();
    assert!(refused.contains("add --odometry /odom, and the numbers that it used"), "{refused}");
    let refused = temp.run("import drive.mcap -o my-robot --odometry /odom").refused();
    assert!(refused.contains("that /odom was computed with are unknown"), "{refused}");
    let by_file = ["drive.mcap", "--odometry", "/odom", "--controller", "controller.yaml"];
    let said = same_answer(&temp, &by_file, RUNS, 0.1);
    assert!(said.contains("what they did between two of its messages is lost"), "{said}");

    put(&temp, "nominal.mcap", mystery().odometry_bag(&Geometry::nominal(0.036, 0.372)));
    let by_hand = [&["nominal.mcap", "--odometry", "/odom"], &SHEET[..]].concat();
    std::fs::remove_dir_all(temp.path("my-robot")).unwrap();
    same_answer(&temp, &by_hand, RUNS, 0.1);

    temp.write(
        "controller.yaml",
        &controller.replace("    wheel_radius:", "    open_loop: true\n    wheel_radius:"),
    );
    let refused = temp.run_with(&[&["import"], &by_file[..]].concat(), "").refused();
    assert!(refused.contains("what was commanded, and not what the wheels did"), "{refused}");
}

#[test]
fn a_tracker_that_drops_out_costs_runs_or_poses_and_not_the_answer() {
    let temp = TempFolder::new();
    let mut log = mystery();
    let first_s = log.poses[0].t_s;
    // Out for 2.1 s in every 7.3 s, and for the whole of a spin that takes 21 s.
    log.poses.retain(|pose| {
        let t_s = pose.t_s - first_s;
        t_s % 7.3 > 2.1 && !(160.0..230.0).contains(&t_s)
    });
    put(&temp, "drive.mcap", log.bag());
    let line = [&["import", "drive.mcap", "-o", "my-robot", "--json"], &SHEET[..]].concat();
    let told = temp.run_with(&line, "").ok().json();
    let left_out = told["left_out"].as_array().unwrap();
    assert!(!left_out.is_empty() && left_out.len() <= 3, "{told:#}");
    assert!(left_out.iter().all(|left| left["why"] == "no pose was measured in it"), "{told:#}");
    let (value, sigma) = speed_growth(&temp, "my-robot");
    let (expected, sigma_whole) = speed_growth(&temp, MYSTERY);
    assert!(sigma > sigma_whole, "fewer poses say less");
    assert!((value - expected).abs() < 2.0 * sigma, "{value} ± {sigma}, not {expected}");
}

#[test]
fn a_run_that_was_pushed_backwards_by_hand_is_a_run_and_turns_nothing_round() {
    let temp = TempFolder::new();
    let mut log = mystery();
    log.push_backwards(LATE_S, 8.0);
    put(&temp, "drive.mcap", log.bag());
    let said = same_answer(&temp, &[&["drive.mcap"], &SHEET[..]].concat(), RUNS + 1, 1.0);
    assert!(!said.contains("backwards") && !said.contains("mirrored"), "{said}");
}

/// One error for each, and nothing written.
#[test]
fn what_cannot_be_imported_is_one_error_and_no_folder() {
    let temp = TempFolder::new();
    let log = OneLog::of_runs(Path::new(MYSTERY), 0.0, 4..8);
    let other = OneLog::of_runs(Path::new(MYSTERY), 0.0, 12..16);
    let whole = log.bag();
    let apart_s = other.poses[0].t_s - log.wheels[0].0;
    let mut mixed = OneLog::of_runs(Path::new(MYSTERY), 0.0, 4..8);
    mixed.poses.clone_from(&other.poses);
    put(&temp, "no-overlap.mcap", mixed.bag());
    mixed.poses.iter_mut().for_each(|pose| pose.t_s -= apart_s);
    put(&temp, "other-robot.mcap", mixed.bag());
    put(&temp, "whole.mcap", &whole);
    put(&temp, "cut-off.mcap", &whole[..whole.len() / 20]);
    let mut corrupt = whole.clone();
    corrupt[whole.len() / 40] ^= 1;
    put(&temp, "corrupt.mcap", corrupt);
    put(&temp, "wrong.mcap", of_types("sensor_msgs/msg/JointState"));
    put(&temp, "unknown.mcap", of_types("my_robot_msgs/msg/Wheels"));
    put(&temp, "empty.mcap", bag(&[]).unwrap());
    temp.write("a.yaml", "wheel_radius: big\nwheel_separation: 1\n");
    let cases = [
        ("cut-off.mcap", "the bag is cut off at byte", "nothing in it is known to be the wheels"),
        ("corrupt.mcap", "a chunk is corrupt, at byte", "nothing in it is known to be the wheels"),
        ("wrong.mcap", "", "/wheels: sensor_msgs/msg/JointState (cannot be read: it ends before"),
        ("unknown.mcap", "", "/wheels: my_robot_msgs/msg/Wheels (not used)"),
        ("empty.mcap", "", "nothing in it is known to be the wheels"),
        (
            "whole.mcap --pose /nowhere",
            "",
            "no poses are called `/nowhere`; choose one of /tracker",
        ),
        ("whole.mcap --pose /joint_states", "", "no poses are called `/joint_states`"),
        ("whole.mcap --wheels left,right", "", "no topic has the joints left and right"),
        (
            "whole.mcap --odometry /odom --wheel-radius 1m --track-width 1m",
            "",
            "no odometry is called `/odom`",
        ),
        (
            "whole.mcap --controller a.yaml",
            "",
            "a.yaml, line 1: wheel_radius = `big` is not a number",
        ),
        ("no-overlap.mcap", "", "have no motion in common"),
        ("no-overlap.mcap", "", "s after the wheels end"),
        ("other-robot.mcap", "", "have no motion in common"),
        ("nowhere.mcap", "", "nowhere.mcap"),
    ];
    let before = temp.listing();
    for (arguments, warning, says) in cases {
        let said = temp.run(&format!("import {arguments} -o my-robot")).refused();
        let said = said.replace("\n  try: ", "; ");
        let error = said.lines().find(|line| line.starts_with("error: ")).unwrap();
        assert!(error.contains(says), "{arguments}: {said}");
        assert!(said.contains(warning), "{arguments}: {said}");
        assert_eq!(temp.listing(), before, "{arguments}");
    }
}

/// Wheels of this type, which are none of it, and poses.
fn of_types(wheels: &str) -> Vec<u8> {
    let log = OneLog::of_runs(Path::new(MYSTERY), 0.0, 4..5);
    let mut bag = BagWriter::new(Vec::new()).unwrap();
    let joints = bag.channel("/wheels", wheels, "");
    let poses = bag.channel("/tracker/pose", "geometry_msgs/msg/PoseStamped", "");
    for pose in &log.poses {
        bag.message(joints, pose.t_s, &encode_joints(pose.t_s, &[])[..12]).unwrap();
        bag.message(poses, pose.t_s, &encode_pose("map", pose)).unwrap();
    }
    bag.finish().unwrap()
}

/// Cut off in the middle, a bag still gives the runs that are whole.
#[test]
fn a_bag_that_a_crash_cut_off_gives_the_runs_before_that() {
    let temp = TempFolder::new();
    let bag = mystery().bag();
    put(&temp, "drive.mcap", &bag[..bag.len() * 3 / 5]);
    let line = [&["import", "drive.mcap", "-o", "my-robot", "--json"], &SHEET[..]].concat();
    let outcome = temp.run_with(&line, "").ok();
    assert!(outcome.stderr.contains("the bag is cut off at byte"), "{}", outcome.stderr);
    let runs = outcome.json()["runs"].as_array().unwrap().len();
    assert!((4..RUNS).contains(&runs), "{runs}");
}

/// The gyro sits upside down: left is positive all the same.
#[test]
fn a_gyro_and_a_battery_become_columns_of_every_run() {
    let temp = TempFolder::new();
    let mut log = OneLog::of_runs(Path::new(MYSTERY), LATE_S, 4..8);
    log.has_gyro_and_battery = true;
    put(&temp, "drive.mcap", log.bag());
    let line = [&["import", "drive.mcap", "-o", "my-robot"], &SHEET[..]].concat();
    let outcome = temp.run_with(&line, "").ok();
    assert!(outcome.stderr.contains("the z axis of the gyro points down"), "{}", outcome.stderr);
    for (run, sign) in [("02_spin_left", 1.0), ("03_spin_right", -1.0)] {
        let text = String::from_utf8(temp.read(&format!("my-robot/runs/{run}.csv"))).unwrap();
        let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
        let numbers = |name: &str| -> Vec<f64> {
            let index = header.iter().position(|own| *own == name).unwrap();
            let cells = text.lines().skip(1).map(|line| line.split(',').nth(index).unwrap());
            cells.filter_map(|cell| cell.parse().ok()).collect()
        };
        let (rates, volts) = (numbers("gyro_z_rad_s"), numbers("bus_v"));
        assert!(rates.len() > 100 && volts.len() > 100, "{} {}", rates.len(), volts.len());
        assert!(volts.iter().all(|volts| *volts == 12.25));
        // They turn one way all the time.
        let mean = rates.iter().sum::<f64>() / rates.len() as f64;
        assert!(sign * mean > 0.5, "{run}: {mean}");
    }
    let refused = temp.run("import drive.mcap -o other --imu /gyro").refused();
    assert!(refused.contains("no gyro is called `/gyro`") && refused.contains("/imu"), "{refused}");
}

/// What nobody gave is estimated, near what it is, and one line says so.
#[test]
fn what_is_assumed_of_the_robot_is_said_in_one_line_with_the_options_that_give_it() {
    let temp = TempFolder::new();
    put(&temp, "drive.mcap", mystery().bag());
    let said = |arguments: &str, folder: &str| {
        let outcome = temp.run(&format!("import drive.mcap -o {folder} {arguments}")).ok();
        let line =
            outcome.stdout.lines().find(|line| line.starts_with("robot ")).map(str::to_owned);
        line.unwrap()
    };
    let line = said("", "none");
    assert!(
        line.contains("both are estimated")
            && line.contains("give --wheel-radius and --track-width"),
        "{line}"
    );
    let robot = String::from_utf8(temp.read("none/robot.toml")).unwrap();
    let robot: toml::Value = toml::from_str(&robot).unwrap();
    for (key, is_m) in [("wheel_radius_m", 0.036), ("track_width_m", 0.372)] {
        let off = robot[key].as_float().unwrap() / is_m - 1.0;
        assert!(off.abs() < 0.02, "{key} is off by {off}");
    }
    let line = said("--wheel-radius 36mm", "radius");
    assert!(
        line.contains("the track width is estimated") && !line.contains("--wheel-radius"),
        "{line}"
    );
    let line = said("--wheel-radius 36mm --track-width 37.2cm", "both");
    assert!(line.ends_with("track width 0.372 m"), "{line}");
}

/// The mystery's radius grows with speed, which no program can be told: each says so, with its cost.
#[test]
fn each_program_says_what_it_cannot_be_told() {
    let temp = TempFolder::new();
    runs_of(&temp, "mystery-robot", &[""], "robot");
    temp.run("explain robot --save robot/model.toml").ok();
    let names = ["diff_drive_controller", "turtlebot3_node", "linorobot2", "WPILib"];
    for (format, name) in ["ros2", "turtlebot3", "linorobot2", "wpilib"].into_iter().zip(names) {
        let outcome = temp.run(&format!("export robot --to {format}")).ok();
        let said = outcome.stderr;
        let starts = format!("warning: {name} cannot be told: wheel radius grows with speed");
        assert!(said.contains(&starts), "{said}");
        let cost_mm = said.split("this costs ").nth(1).and_then(|rest| rest.split(' ').next());
        let cost_mm: f64 = cost_mm.unwrap().parse().unwrap();
        assert!((1.0..20.0).contains(&cost_mm), "{said}");
        assert!(outcome.stdout.contains("not expressible: wheel radius grows with speed"));
    }
}

/// What `export` writes is read again, and says the same.
#[test]
fn exported_bags_and_parameters_come_back() {
    let temp = TempFolder::new();
    temp.run_with(&["export", MYSTERY, "--to", "mcap", "-o", "drive.mcap"], "").ok();
    temp.run_with(&["export", MYSTERY, "--to", "ros2", "-o", "controller.yaml"], "").ok();
    let refused =
        temp.run_with(&["export", MYSTERY, "--to", "ros2", "-o", "controller.yaml"], "").refused();
    assert!(refused.contains("controller.yaml exists") && refused.contains("--force"), "{refused}");
    temp.run("import drive.mcap -o by-joints --controller controller.yaml").ok();
    let (value, _) = speed_growth(&temp, "by-joints");
    temp.run("import drive.mcap -o by-odometry --odometry /odom --controller controller.yaml").ok();
    let (by_odometry, sigma) = speed_growth(&temp, "by-odometry");
    assert!((value - by_odometry).abs() < 0.1 * sigma, "{value} {by_odometry}");
    let (expected, sigma) = speed_growth(&temp, MYSTERY);
    assert!((value - expected).abs() < 0.1 * sigma, "{value} {expected}");
}

#[test]
fn a_run_that_is_recorded_as_a_bag_too_is_imported_from_it_and_a_bag_is_never_replaced() {
    let temp = TempFolder::new();
    let line = ["record", "mine", "arc", "1m", "90deg", "--mcap", "drive.mcap"];
    let said = temp.run_with(&line, "").ok().stderr;
    assert!(said.contains("drive.mcap written"), "{said}");
    let listed = temp.run_with(&["import", "drive.mcap"], "").ok().stdout;
    for topic in
        ["--wheels left_wheel_joint,right_wheel_joint", "--pose /measured", "--odometry /odom"]
    {
        assert!(listed.contains(topic), "{listed}");
    }
    let has = |topic: &str| listed.lines().any(|line| line.contains(topic));
    assert!(has("/dynamic_joint_states") && has("/battery_state"), "{listed}");
    let (bag, runs) = (temp.read("drive.mcap"), temp.path("mine/runs"));
    temp.run("import drive.mcap -o imported --wheel-radius 36mm --track-width 37.2cm").ok();
    let rows = |folder: &str| {
        let runs = std::fs::read_dir(temp.path(folder).join("runs")).unwrap();
        let first = runs.map(|run| run.unwrap().path()).next().unwrap();
        ::campaign::read_run(&first).unwrap().0
    };
    let last = |folder| rows(folder).iter().rev().find_map(|row| Some([row.x_m?, row.y_m?]));
    let (recorded, imported) = (last("mine").unwrap(), last("imported").unwrap());
    let volts = |folder| rows(folder).iter().rev().find_map(|row| row.bus_v).unwrap();
    assert!((volts("mine") - volts("imported")).abs() < 0.05, "{} V", volts("imported"));
    // The bag has both; the import cuts the run where the robot rests.
    let off_m = (recorded[0] - imported[0]).hypot(recorded[1] - imported[1]);
    assert!(off_m < 5e-3, "{recorded:?} {imported:?}");
    let refused = temp.run_with(&line, "").refused();
    assert!(refused.contains("drive.mcap exists"), "{refused}");
    assert_eq!(temp.read("drive.mcap"), bag);
    assert_eq!(std::fs::read_dir(runs).unwrap().count(), 1);
}
