//! Two processes in real time: a robot behind TCP or a pseudo-terminal, and `beeline` on it.
//!
//! These tests wait more than they compute. `cargo xtask test` runs several of them at once, apart from tests
//! that keep the processor busy.

mod key;
mod network;
#[cfg(unix)]
mod robot_page;
#[cfg(target_os = "linux")]
mod watch;

use std::io::{BufRead, BufReader, Write};
use std::process::Child;
use std::time::{Duration, Instant};

use campaign::Campaign;

use crate::outcome::{collect, wait_for};
use crate::served::{SHORT_M, Served, interrupt, signal};
use crate::temp_folder::TempFolder;

const TCP: &str = "tcp:127.0.0.1:0";
const PTY: &str = "pty";

/// In the second drive of a calibration: the new W_T is in use, and not saved.
const SECOND_DRIVE_M: f64 = SHORT_M * 1.3;

#[test]
fn a_calibration_over_tcp_completes() {
    calibration_completes(TCP);
}

#[test]
#[cfg(unix)]
fn a_calibration_over_a_serial_port_completes() {
    calibration_completes(PTY);
}

fn calibration_completes(listen: &str) {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, listen);
    let outcome = robot.calibrated().ok();
    assert!(outcome.stdout.contains("Drives straight:"), "{outcome:#?}");
    assert!(robot.picture().exists());
    // One revolution seen by a camera of 2 mrad: a sigma of 0.004 at most.
    assert!((robot.wheel_weight() - 0.96).abs() < 0.016, "{}", robot.wheel_weight());
    let identity = robot.identify();
    assert_eq!(identity["identity"]["unsaved"], false, "{identity}");
    assert_eq!(identity["status"]["state"], "idle", "{identity}");

    robot.run("calibrate --undo").ok();
    assert_eq!(robot.wheel_weight(), 1.0);
}

#[test]
fn a_host_killed_over_tcp_leaves_a_stopped_robot_that_can_be_calibrated_again() {
    killed_and_reconnected(TCP);
}

#[test]
#[cfg(unix)]
fn a_host_killed_over_a_serial_port_leaves_a_stopped_robot_that_can_be_calibrated_again() {
    killed_and_reconnected(PTY);
}

fn killed_and_reconnected(listen: &str) {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, listen);
    robot.run("config save").ok();
    let flash = robot.flash();

    let mut host = robot.calibrate();
    robot.wait_until_travelled(SECOND_DRIVE_M);
    host.kill().unwrap();
    host.wait().unwrap();

    let fault = wait_for("the fault of a robot without its host", || {
        let fault = robot.identify()["status"]["fault"]["fault"].clone();
        (!fault.is_null()).then_some(fault)
    });
    assert!(fault == "link_lost" || fault == "time_to_live", "{fault}");
    assert!(robot.flash() == flash, "what is saved is as it was");
    assert!(!robot.picture().exists());

    // Latched: it does not drive before somebody has cleared it.
    let message = robot.run("drive straight 1rev").refused();
    assert!(message.contains("fault is latched") && message.contains("beeline clear"), "{message}");
    let message = robot.calibrated().refused();
    assert!(message.contains("fault is latched"), "{message}");
    // The fault is reported while the robot still brakes, and cleared once it stands.
    wait_for("the robot to stand", || {
        (robot.identify()["status"]["state"] == "faulted").then_some(())
    });
    robot.run("clear").ok();

    let outcome = robot.calibrated().ok();
    assert!(outcome.stderr.contains("discarded"), "the unsaved W_T: {outcome:#?}");
    assert!(robot.flash() != flash);
    assert!((robot.wheel_weight() - 0.96).abs() < 0.016, "{}", robot.wheel_weight());
}

#[test]
fn ctrl_c_in_a_drive_stops_the_robot_and_changes_nothing() {
    for travel_m in [SHORT_M * 0.3, SECOND_DRIVE_M] {
        let temp = TempFolder::new();
        let robot = Served::start(&temp, TCP);
        robot.run("config save").ok();
        let flash = robot.flash();
        let before = temp.listing();

        let host = robot.calibrate();
        robot.wait_until_travelled(travel_m);
        interrupt(&host);
        let outcome = collect(host);
        assert_eq!(outcome.code, Some(130), "{outcome:#?}");
        assert_eq!(outcome.stdout, "");
        assert!(outcome.stderr.contains("error: stopped by Ctrl-C"), "{outcome:#?}");

        let identity = robot.identify();
        assert_eq!(identity["status"]["state"], "idle", "motors off: {identity}");
        assert!(identity["status"]["fault"].is_null(), "a stop is no fault: {identity}");
        assert!(robot.flash() == flash, "what is saved is as it was");
        assert_eq!(robot.wheel_weight(), 1.0, "and in use again");
        assert_eq!(temp.listing(), before, "no picture, not even half of one");
    }
}

#[test]
fn ctrl_c_at_a_question_changes_nothing() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    let mut host = temp.spawn(&["calibrate", "--port", robot.port()]);
    wait_for_question(&mut host);
    interrupt(&host);
    let outcome = collect(host);
    assert_eq!(outcome.code, Some(130), "{outcome:#?}");
    assert_eq!(robot.identify()["status"]["state"], "idle");
    assert!(!robot.picture().exists());
}

fn wait_for_question(host: &mut Child) {
    let mut stderr = BufReader::new(host.stderr.take().unwrap());
    let mut said = Vec::new();
    while !said.ends_with(b"?") {
        let mut line = Vec::new();
        assert!(stderr.read_until(b'?', &mut line).unwrap() > 0, "no question was asked");
        said.extend(line);
    }
}

#[test]
fn a_second_client_can_stop_what_the_first_one_drives() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    let host = robot.calibrate();
    robot.wait_until_travelled(SHORT_M * 0.2);
    robot.run("stop --now").ok();
    let outcome = collect(host);
    assert_eq!(outcome.code, Some(2), "{outcome:#?}");
    let fault = robot.identify()["status"]["fault"]["fault"].clone();
    assert!(fault.as_str().is_some_and(|fault| fault.contains("stop")), "{fault}");
    robot.run("clear").ok();
    assert_eq!(robot.identify()["status"]["state"], "idle");
}

#[test]
fn what_is_watched_is_one_json_value_a_line() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    let outcome = robot.run("watch --json --rate 50 --for 300ms").ok();
    let frames = outcome.stdout.lines().map(|line| {
        let value: serde_json::Value = serde_json::from_str(line).expect("one value a line");
        value
    });
    let mut times: Vec<_> = frames.filter_map(|frame| frame["t_us"].as_u64()).collect();
    assert!(times.len() >= 5, "{outcome:#?}");
    assert!(times.is_sorted());
    times.dedup();
    assert!(times.windows(2).all(|pair| (pair[1] - pair[0]) % 20_000 == 0), "{times:?}");
}

/// Long enough for anything to happen on the way, and slow: 8 revolutions in 20 s.
const LONG: &str = "straight 8rev";

#[test]
fn ctrl_c_stops_the_robot_at_once_however_seldom_it_reports() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    let host = robot.spawn(&format!("record robot {LONG} --rate 5"));
    robot.wait_until_travelled(0.1);
    interrupt(&host);
    let pressed = Instant::now();
    let outcome = collect(host);
    assert_eq!(outcome.code, Some(130), "{outcome:#?}");
    assert!(outcome.stderr.contains("stands still, its motors are off"), "{outcome:#?}");
    // The ramp of the paper's profile takes 5.2 s, of which 18 cm are left at the most; 16 s of the
    // motion were to come.
    assert!(pressed.elapsed() < Duration::from_secs(9), "{:?}", pressed.elapsed());
    assert!(robot.travelled_m() < 1.0, "{} m of 1.8 m", robot.travelled_m());
    assert_eq!(robot.identify()["status"]["state"], "idle");
}

#[test]
fn of_a_robot_that_no_longer_answers_nothing_is_claimed() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    let host = robot.spawn(&format!("drive {LONG}"));
    robot.wait_until_travelled(0.05);
    signal(robot.id(), "STOP");
    interrupt(&host);
    let outcome = collect(host);
    signal(robot.id(), "CONT");
    assert_eq!(outcome.code, Some(130), "{outcome:#?}");
    assert!(!outcome.stderr.contains("motors are off"), "{outcome:#?}");
    assert!(outcome.stderr.contains("is not known"), "{outcome:#?}");
}

#[test]
fn ctrl_c_between_the_last_reading_and_the_saving_saves_nothing() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    robot.run("config save").ok();
    let flash = robot.flash();
    // 1 rev with W_T = 0.96 ends 2.7 mm to the right for each 0.024 rad: the reading says 0.96.
    let mut host = robot.spawn(
        "calibrate --yes --measure ask --ruler 0.1mm --start-heading 0mrad --distance 1rev \
         --cruise 1.2rev/s --acceleration 2rev/s^2",
    );
    let mut stdin = host.stdin.take().unwrap();
    let mut stderr = host.stderr.take().unwrap();
    wait_for_text(&mut stderr, b"1mm): ");
    stdin.write_all(b"-2.7mm\n").unwrap();
    wait_for_text(&mut stderr, b"1mm): ");
    // Both are pending when the process continues: the last answer, and Ctrl-C.
    signal(host.id(), "STOP");
    stdin.write_all(b"0mm\n").unwrap();
    interrupt(&host);
    signal(host.id(), "CONT");
    let outcome = collect(host);
    assert_eq!(outcome.code, Some(130), "{outcome:#?}");
    assert!(robot.flash() == flash, "what is saved is as it was");
    assert_eq!(robot.wheel_weight(), 1.0, "and in use again");
}

fn wait_for_text(stderr: &mut impl std::io::Read, text: &[u8]) {
    let mut said = Vec::new();
    let mut byte = [0];
    while !said.ends_with(text) {
        assert_eq!(stderr.read(&mut byte).unwrap(), 1, "{}", String::from_utf8_lossy(&said));
        said.push(byte[0]);
    }
}

#[test]
fn a_recording_that_is_ended_by_a_signal_is_kept_and_leaves_nothing_else() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    let host = robot.spawn(&format!("record robot {LONG}"));
    robot.wait_until_travelled(0.05);
    let runs = || -> Vec<_> {
        let entries = std::fs::read_dir(temp.path("robot/runs")).into_iter().flatten();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    };
    assert!(runs().is_empty(), "whatever kills it now leaves nothing");
    signal(host.id(), "TERM");
    assert_eq!(collect(host).code, Some(130));
    assert_eq!(runs(), ["01_straight.csv"]);
    assert_eq!(robot.identify()["status"]["state"], "idle", "and the robot stands");
}

#[test]
fn runs_of_a_robot_that_was_switched_off_in_between_keep_their_order_in_time() {
    let temp = TempFolder::new();
    let record = || {
        let robot = Served::start(&temp, TCP);
        let drive = "record robot straight 5cm --cruise 0.2m/s --acceleration 0.5m/s^2";
        robot.run(drive).ok();
        drop(robot);
        std::fs::remove_file(temp.path("track.csv")).unwrap();
    };
    record();
    record();
    let campaign = Campaign::read(&temp.path("robot")).unwrap();
    let started_s: Vec<_> = campaign.runs.iter().filter_map(|run| run.facts.started_s).collect();
    // A drive of half a second, and its rests.
    assert!(started_s.len() == 2 && started_s[1] - started_s[0] > 1.0, "{started_s:?}");
    assert!(campaign.robot.uid.is_some_and(|uid| uid.len() == 24), "the board's number");

    // Another robot of the same kind: the seed is the simulated board's number.
    let other = Served::start_with(&temp, TCP, "--seed 99");
    let message = other.run("record robot straight 5cm").refused();
    assert!(message.contains("uid = ") && message.contains("of another robot"), "{message}");
    // A camera of a millimetre, where the motion was to be 50.
    assert!(other.travelled_m() < 0.01, "it did not move");
}

#[test]
fn a_campaign_knows_its_robot_and_is_not_gone_on_with_by_another() {
    let temp = TempFolder::new();
    temp.write(
        "plan.toml",
        "acceleration_mps2 = 0.5\n[[run]]\nname = \"a\"\npieces = [{ rest_s = 0.3 }]\n\
         [[run]]\nname = \"b\"\npieces = [{ rest_s = 0.3 }]\n",
    );
    let record = "campaign record robot --plan plan.toml --measure none --yes";
    let robot = Served::start(&temp, TCP);
    robot.run(record).ok();
    drop(robot);
    std::fs::remove_file(temp.path("track.csv")).unwrap();
    let campaign = Campaign::read(&temp.path("robot")).unwrap();
    assert!(campaign.robot.uid.is_some_and(|uid| uid.len() == 24), "the board's number");
    std::fs::remove_file(temp.path("robot/runs/02_b.csv")).unwrap();
    let text = String::from_utf8(temp.read("robot/robot.toml")).unwrap();
    let second = text.rfind("[[run]]").unwrap();
    temp.write("robot/robot.toml", &text[..second]);

    let other = Served::start_with(&temp, TCP, "--seed 99");
    let message = other.run(record).refused();
    assert!(message.contains("uid = ") && message.contains("of another robot"), "{message}");
    assert!(!temp.path("robot/runs/02_b.csv").exists());
}

#[test]
fn watch_ends_when_its_reader_leaves() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    let mut host = robot.spawn("watch --json");
    let mut stdout = BufReader::new(host.stdout.take().unwrap());
    stdout.read_line(&mut String::new()).unwrap();
    drop(stdout);
    collect(host).ok();
}

#[test]
fn a_client_that_comes_while_the_robot_drives_does_not_move_it_and_a_later_one_does() {
    let temp = TempFolder::new();
    let robot = Served::start_with(&temp, TCP, "--reset-on-connect");
    let mut host = robot.spawn(&format!("drive {LONG}"));
    robot.wait_until_travelled(0.1);
    // It takes the first one's place, and the robot is still driving then.
    robot.identify();
    host.wait().unwrap();
    let steps_m = || -> f64 {
        let places = robot.places_m();
        let steps =
            places.windows(2).map(|pair| (pair[1].0 - pair[0].0).hypot(pair[1].1 - pair[0].1));
        steps.fold(0.0, f64::max)
    };
    // 0.12 m/s at 25 pictures a second is 5 mm, and a millimetre of noise in each.
    assert!(steps_m() < 0.02, "{} m at once", steps_m());
    wait_for("the robot to be back at its line", || {
        robot.identify();
        std::thread::sleep(Duration::from_millis(300));
        (robot.travelled_m() < 0.03).then_some(())
    });
}

#[test]
fn machines_are_told_that_unsaved_changes_were_dropped() {
    let temp = TempFolder::new();
    let robot = Served::start(&temp, TCP);
    robot.run("config set geometry.wheel_weight 0.99").ok();
    let outcome = robot.run(
        "calibrate --json --measure track:track.csv --yes --distance 1rev --cruise 1.2rev/s \
         --acceleration 2rev/s^2",
    );
    let value = outcome.ok().json();
    assert_eq!(value["unsaved_changes_dropped"], true, "{value}");
    assert_eq!(value["before"]["driven_with"], 1.0, "{value}");
}
