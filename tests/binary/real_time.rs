//! Two processes in real time: a robot behind TCP or a pseudo-terminal, and `beeline` on it.

use std::io::{BufRead, BufReader};
use std::process::Child;

use crate::desk::Desk;
use crate::outcome::{collect, wait_for};
use crate::served::{SHORT_M, Served, interrupt};

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
    let desk = Desk::new();
    let robot = Served::start(&desk, listen);
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
    let desk = Desk::new();
    let robot = Served::start(&desk, listen);
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
    robot.run("clear").ok();

    let outcome = robot.calibrated().ok();
    assert!(outcome.stderr.contains("dropped"), "the unsaved W_T: {outcome:#?}");
    assert!(robot.flash() != flash);
    assert!((robot.wheel_weight() - 0.96).abs() < 0.016, "{}", robot.wheel_weight());
}

#[test]
fn ctrl_c_in_a_drive_stops_the_robot_and_changes_nothing() {
    for travel_m in [SHORT_M * 0.3, SECOND_DRIVE_M] {
        let desk = Desk::new();
        let robot = Served::start(&desk, TCP);
        robot.run("config save").ok();
        let flash = robot.flash();
        let before = desk.listing();

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
        assert_eq!(desk.listing(), before, "no picture, not even half of one");
    }
}

#[test]
fn ctrl_c_at_a_question_changes_nothing() {
    let desk = Desk::new();
    let robot = Served::start(&desk, TCP);
    let mut host = desk.spawn(&["calibrate", "--port", robot.port()]);
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
    let desk = Desk::new();
    let robot = Served::start(&desk, TCP);
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
    let desk = Desk::new();
    let robot = Served::start(&desk, TCP);
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
