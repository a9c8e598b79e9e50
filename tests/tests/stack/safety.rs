//! Whatever fails, are the motors off in time, and does the fault have the right name?
//!
//! Measured at the plant: a driver that is off carries exactly no current, whatever the firmware reports.

use crate::fault_cases::{ROBOT_FAULTS, WHEEL_FAULTS, WheelCase};
use beeline_tests::robot::{Robot, Snapshot, meters, on_robot};
use host_link::motion::Motion;
use shared_proto::{Command, Fault, FaultReport, Refusal, State, Wheel, WheelPair};
use sim_target::plant::PlantFault;
use sim_target::{Scenario, now_us};

/// The paper's cruise, reached in one second, far enough for everything here.
pub const AHEAD: Motion =
    Motion { distance: WheelPair::both(20.0), acceleration: 0.523, ..Motion::PAPER };

/// Zero duty this long after the event at cruise [us].
const CRUISE_US_MAX: u64 = 100_000;

/// Farthest that any part of the drive may move when the fault is there from the start [m].
const START_M_MAX: f64 = 0.010;

/// A probe takes 1.5 s at most.
const START_S_MAX: f64 = 2.0;

/// Forward and backward at the paper's cruise, a spin, and more than three times as fast.
fn cruises() -> [(&'static str, Motion); 4] {
    [
        ("ahead", AHEAD),
        ("back", AHEAD.reversed()),
        ("spin", Motion { distance: WheelPair::new(-20.0, 20.0), ..AHEAD }),
        ("fast", meters(4.0, 4.0, 0.4, 0.4)),
    ]
}

/// What broke, the fault that was reported, and for how long the motors carried current after it.
struct Broken {
    case: String,
    fault: Fault,
    off_us: u64,
    /// When the wheel at fault had all but stopped: below 20 mm/s.
    stood_us: Option<u64>,
}

/// Prints every case, and fails with all that are wrong.
fn check_all(broken: &[(Broken, Vec<Fault>)], off_us_max: u64) {
    let mut wrong = Vec::new();
    for (Broken { case, fault, off_us, .. }, expected) in broken {
        let line = format!("{case}: {fault}, off after {:.1} ms", *off_us as f64 * 1e-3);
        println!("{line}");
        if !expected.contains(fault) || *off_us > off_us_max {
            wrong.push(line);
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), broken.len(), wrong.join("\n"));
}

#[test]
fn a_wheel_fault_at_cruise_is_named_and_the_motors_are_off_within_100_ms() {
    let mut broken = Vec::new();
    for &(name, breaks, expected) in WHEEL_FAULTS {
        for wheel in Wheel::BOTH {
            for (way, motion) in cruises() {
                // The count changes every 2 ms: the event meets it at different phases.
                for phase_us in [0, 700, 1300] {
                    let case = format!("{name}, {} wheel, {way}, +{phase_us} us", wheel.name());
                    let fault = breaks(wheel);
                    let told_apart = way == "fast" && name == "wheel blocked";
                    let names =
                        if told_apart { vec![Fault::Stall(wheel)] } else { expected(wheel) };
                    broken.push((break_at_cruise(case, &motion, phase_us, fault), names));
                }
            }
        }
    }
    check_all(&broken, CRUISE_US_MAX);
}

#[test]
fn a_robot_fault_at_cruise_is_named_and_the_motors_are_off_within_100_ms() {
    let mut broken = Vec::new();
    for &(name, fault, expected) in ROBOT_FAULTS {
        for (way, motion) in cruises() {
            broken.push((
                break_at_cruise(format!("{name}, {way}"), &motion, 0, fault),
                vec![expected],
            ));
        }
    }
    check_all(&broken, CRUISE_US_MAX);
}

#[test]
fn a_motor_lead_that_comes_off_at_cruise_is_named_within_100_ms_of_the_wheel_standing() {
    let mut broken = Vec::new();
    for wheel in Wheel::BOTH {
        for (way, motion) in cruises() {
            let case = format!("motor unplugged, {} wheel, {way}", wheel.name());
            let outcome = break_at_cruise(case, &motion, 0, PlantFault::MotorUnplugged(wheel));
            // Nothing tells until the wheel lags: the robot's mass keeps it rolling. From the fast cruise
            // it rolls for so long that it falls 20 mm behind first.
            if way == "fast" {
                broken.push((outcome, vec![Fault::FollowingError(wheel)]));
            } else {
                let stood_us = outcome.stood_us.expect("it rolls out");
                let after_us = outcome.off_us - stood_us;
                assert!(after_us <= CRUISE_US_MAX, "{}: {after_us} us", outcome.case);
                broken.push((outcome, vec![Fault::Stall(wheel)]));
            }
        }
    }
    // Rolling out takes 130 ms; 20 mm behind takes a robot at 0.4 m/s 220 ms.
    check_all(&broken, 250_000);
}

/// Breaks something at cruise.
fn break_at_cruise(case: String, motion: &Motion, phase_us: u64, fault: PlantFault) -> Broken {
    on_robot(&Scenario::default(), async |robot| {
        let id = robot.cruise(motion, 2.0 + phase_us as f64 * 1e-6).await;
        let event_us = now_us();
        assert!(robot.snapshot().is_powered(), "{case}: it drives");
        robot.testbed.inject(fault);
        robot.renew(id, 0.5).await;
        let report = robot.fault().await.unwrap_or_else(|| panic!("{case}: no fault"));
        assert_eq!(robot.state().await, State::Faulted, "{case}");
        stays_off(robot, &report).await;
        let last_us = robot.last_powered_us(event_us).unwrap_or(event_us);
        let snapshots = robot.snapshots_from(event_us);
        let stood = report.fault.wheel().and_then(|wheel| {
            let slow = |w: &&[Snapshot]| {
                (w[5].rolled_m.get(wheel) - w[0].rolled_m.get(wheel)).abs() < 0.0001
            };
            snapshots.windows(6).find(slow).map(|w| w[0].t_us - event_us)
        });
        Broken { case, fault: report.fault, off_us: last_us - event_us, stood_us: stood }
    })
}

/// The motors are off, the fault is latched, and both stay so.
async fn stays_off(robot: &mut Robot, report: &FaultReport) {
    let from_us = now_us();
    robot.listen(1.0).await;
    assert_eq!(robot.last_powered_us(from_us), None, "{}: a motor is on again", report.fault);
    let still = robot.fault().await.expect("still latched");
    assert_eq!((still.fault, still.number, still.t_us), (report.fault, report.number, report.t_us));
}

#[test]
fn a_fault_that_is_there_from_the_start_is_named_before_the_robot_has_moved_10_mm() {
    let mut cases: Vec<WheelCase> = vec![
        ("encoder unplugged", PlantFault::EncoderUnplugged, |w| vec![Fault::NoResponse(w)]),
        ("encoder reversed", PlantFault::EncoderReversed, |w| vec![Fault::EncoderReversed(w)]),
        ("motor reversed", PlantFault::MotorReversed, |w| vec![Fault::EncoderReversed(w)]),
    ];
    // Without a first count it cannot be told which of wheel, motor and encoder failed.
    for (name, breaks) in [
        ("wheel blocked", PlantFault::WheelBlocked as fn(Wheel) -> PlantFault),
        ("wheel jammed", PlantFault::WheelJammed),
        ("motor unplugged", PlantFault::MotorUnplugged),
    ] {
        cases.push((name, breaks, |w| vec![Fault::NoResponse(w)]));
    }
    let mut farthest_m: f64 = 0.0;
    for (name, breaks, expected) in cases {
        for wheel in Wheel::BOTH {
            for (way, motion) in cruises() {
                let case = format!("{name}, {} wheel, {way}", wheel.name());
                let moved_m =
                    broken_from_the_start(&case, &motion, breaks(wheel), &expected(wheel));
                farthest_m = farthest_m.max(moved_m);
            }
        }
    }
    println!("farthest: {:.2} mm", farthest_m * 1e3);
}

/// Starts a motion with a broken robot; returns how far it got [m].
fn broken_from_the_start(
    case: &str,
    motion: &Motion,
    fault: PlantFault,
    expected: &[Fault],
) -> f64 {
    on_robot(&Scenario::default(), async |robot| {
        robot.testbed.inject(fault);
        // A hand needs a moment to close.
        robot.listen(0.1).await;
        let (start, start_us) = (robot.snapshot(), now_us());
        robot.cruise(motion, START_S_MAX).await;
        let report = robot.fault().await.unwrap_or_else(|| panic!("{case}: no fault"));
        assert!(expected.contains(&report.fault), "{case}: {}", report.fault);
        let snapshots = robot.snapshots_from(start_us);
        let moved_m =
            snapshots.iter().map(|snapshot| snapshot.moved_since_m(&start)).fold(0.0, f64::max);
        println!("{case}: {} after {:.2} mm", report.fault, moved_m * 1e3);
        assert!(moved_m < START_M_MAX, "{case}: moved {moved_m} m");
        stays_off(robot, &report).await;
        moved_m
    })
}

/// The first instant from which on the robot slows down for good [us].
pub fn begins_to_stop_us(snapshots: &[Snapshot], cruise_mps: f64) -> u64 {
    // A ramp of 0.5 m/s^2 loses 5 mm/s in 10 ms; cruise wobbles by less.
    let speed_mps = |pair: &[Snapshot]| {
        let way_m = pair[10].rolled_m.zip(pair[0].rolled_m).map(|(b, a)| b - a);
        0.5 * (way_m.left + way_m.right) / 0.010
    };
    let last_fast = snapshots.windows(11).rposition(|w| speed_mps(w) > 0.95 * cruise_mps);
    snapshots[last_fast.expect("it cruises")].t_us + 10_000
}

#[test]
fn a_host_killed_mid_run_makes_a_controlled_stop_within_250_ms() {
    for cut_wire in [false, true] {
        on_robot(&Scenario::default(), async |robot| {
            robot.cruise(&AHEAD, 2.0).await;
            let event_us = now_us();
            robot.wire.set_cut(cut_wire);
            // The host is dead: it neither sends nor listens.
            sim_target::sleep_until_us(event_us + 2_000_000).await;
            check_controlled_stop(robot, event_us);

            robot.wire.set_cut(false);
            robot.reconnect(2).await;
            let report = robot.fault().await.expect("latched");
            assert_eq!((report.fault, report.number), (Fault::LinkLost, 1));
            assert_eq!(robot.state().await, State::Faulted);
            stays_off(robot, &report).await;
        });
    }
}

fn check_controlled_stop(robot: &Robot, event_us: u64) {
    let cruise_mps = 0.523 * std::f64::consts::TAU * 0.036;
    let snapshots = robot.snapshots_from(event_us);
    let begins_us = begins_to_stop_us(&snapshots, cruise_mps) - event_us;
    println!("begins to stop after {} ms", begins_us / 1000);
    assert!((1_000..=250_000).contains(&begins_us), "{begins_us}");
    // Controlled: 0.118 m/s at 0.5 m/s^2 take 237 ms and 14 mm; a robot without control rolls differently.
    let stopping = robot.snapshots_from(event_us + begins_us);
    let rolled_m = stopping.last().map_or(0.0, |last| last.moved_since_m(&stopping[0]));
    assert!((0.010..0.018).contains(&rolled_m), "{rolled_m}");
    let off_us = robot.last_powered_us(event_us).expect("it was braked") - event_us;
    assert!(off_us < 1_000_000, "off after {off_us} us");
    let end = stopping.last().expect("watched");
    assert!(robot.snapshots_from(event_us + 1_000_000).iter().all(|s| s.moved_since_m(end) < 1e-4));
}

#[test]
fn a_second_fault_during_the_controlled_stop_cuts_the_motors_and_is_counted() {
    on_robot(&Scenario::default(), async |robot| {
        robot.cruise(&AHEAD, 2.0).await;
        // In the middle of the ramp that begins 180 ms from now and takes 237 ms.
        sim_target::sleep_until_us(now_us() + 300_000).await;
        let event_us = now_us();
        assert!(robot.snapshot().is_powered());
        robot.testbed.inject(PlantFault::EmergencyStop);
        sim_target::sleep_until_us(event_us + 1_000_000).await;
        let off_us = robot.last_powered_us(event_us).unwrap_or(event_us) - event_us;
        assert!(off_us <= 2_000, "{off_us}");
        let report = robot.fault().await.expect("latched");
        assert_eq!((report.fault, report.followed_by), (Fault::LinkLost, 1));
        let clear = Command::ClearFault { number: report.number };
        assert_eq!(robot.ask(clear).await, Err(Refusal::CauseRemains));
        stays_off(robot, &report).await;
    });
}

#[test]
fn a_host_that_talks_but_does_not_renew_is_named_time_to_live() {
    on_robot(&Scenario::default(), async |robot| {
        robot.cruise(&AHEAD, 2.0).await;
        let event_us = now_us();
        while now_us() < event_us + 2_000_000 {
            robot.state().await;
            robot.listen(0.02).await;
        }
        check_controlled_stop(robot, event_us);
        let report = robot.fault().await.expect("latched");
        assert_eq!(report.fault, Fault::TimeToLive);
        stays_off(robot, &report).await;
    });
}

#[test]
fn a_late_control_tick_is_a_fault_and_cuts_the_motors() {
    on_robot(&Scenario::default(), async |robot| {
        let id = robot.cruise(&AHEAD, 2.0).await;
        let event_us = now_us();
        robot.testbed.stall_cpu(3_000);
        robot.renew(id, 0.3).await;
        let report = robot.fault().await.expect("named");
        assert_eq!(report.fault, Fault::DeadlineMissed);
        let off_us = robot.last_powered_us(event_us).unwrap_or(event_us) - event_us;
        assert!(off_us <= 10_000, "{off_us}");
        stays_off(robot, &report).await;
    });
}

#[test]
fn the_emergency_stop_command_cuts_the_motors_at_the_next_tick() {
    on_robot(&Scenario::default(), async |robot| {
        robot.cruise(&AHEAD, 2.0).await;
        let event_us = now_us();
        robot.tell(Command::EmergencyStop).await;
        // Less than a millisecond on the line, and one control period.
        robot.listen(0.3).await;
        let off_us = robot.last_powered_us(event_us).unwrap_or(event_us) - event_us;
        assert!(off_us <= 3_000, "{off_us}");
        let report = robot.fault().await.expect("latched");
        assert_eq!(report.fault, Fault::EmergencyStop);
        // Commanded twice is one fault.
        robot.tell(Command::EmergencyStop).await;
        stays_off(robot, &report).await;
    });
}
