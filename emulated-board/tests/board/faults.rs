//! Whatever breaks at cruise has its name, and the motors are off in time: on the flashed image.

use emulated_board::Bench;
use shared_proto::{Command, Fault, Refusal, State, Wheel};
use sim_target::plant::PlantFault;
use sim_target::{now_us, sleep_until_us};

use super::robot::{AHEAD, Robot};
use super::{emulation, uneventful};

/// What breaks, what it may be called, and how long the motors may be driven after it [ms].
type Case = (&'static str, PlantFault, &'static [Fault], f64);

use Wheel::{Left, Right};

const CASES: &[Case] = &[
    (
        "left encoder's line cut",
        PlantFault::EncoderUnplugged(Left),
        &[Fault::EncoderDead(Left)],
        100.0,
    ),
    (
        "right encoder's line cut",
        PlantFault::EncoderUnplugged(Right),
        &[Fault::EncoderDead(Right)],
        100.0,
    ),
    (
        "left encoder swapped",
        PlantFault::EncoderReversed(Left),
        &[Fault::EncoderReversed(Left)],
        100.0,
    ),
    (
        "right encoder swapped",
        PlantFault::EncoderReversed(Right),
        &[Fault::EncoderReversed(Right)],
        100.0,
    ),
    ("left encoder noisy", PlantFault::EncoderNoise(Left, 5e4), &[Fault::CountRate(Left)], 100.0),
    // A hand that closes in 25 ms stops this cruise within a few counts: it cannot be told from a dead
    // wire in time.
    (
        "left wheel blocked",
        PlantFault::WheelBlocked(Left),
        &[Fault::Stall(Left), Fault::EncoderDead(Left)],
        100.0,
    ),
    (
        "right wheel jammed",
        PlantFault::WheelJammed(Right),
        &[Fault::Stall(Right), Fault::EncoderDead(Right)],
        100.0,
    ),
    // Nothing tells until the wheel has rolled out, which takes 130 ms.
    ("left motor unplugged", PlantFault::MotorUnplugged(Left), &[Fault::Stall(Left)], 250.0),
    ("driver's fault line", PlantFault::DriverFault, &[Fault::Driver], 100.0),
    ("supply dips by 4 V", PlantFault::SupplyDip { volts: 4.0 }, &[Fault::SupplyLow], 100.0),
    ("emergency stop", PlantFault::EmergencyStop, &[Fault::EmergencyStop], 100.0),
];

struct Found {
    fault: Fault,
    off_ms: f64,
}

/// Breaks something at cruise, and mends it again.
async fn break_at_cruise(robot: &mut Robot, case: &Case) -> Found {
    let &(what, breaks, ..) = case;
    let motion = robot.cruise(&AHEAD, 2000).await;
    let monitor = robot.0.monitor.clone();
    assert!(monitor.duty().all(|duty| duty > 0.05), "{what}: it drives");
    let event_us = now_us();
    robot.0.testbed.inject(breaks);
    robot.renew(motion, 400).await;
    let off_us = monitor.last_powered_us().expect("it drove");
    let status = robot.status().await;
    let report = status.fault.unwrap_or_else(|| panic!("{what}: no fault"));
    assert_eq!(status.state, State::Faulted, "{what}");
    // Latched: it is still there, nothing drives, and only its number clears it.
    assert!(
        matches!(robot.ask(Command::Arm { take: false }).await, Err(Refusal::Faulted(_))),
        "{what}"
    );
    robot.renew(motion, 100).await;
    assert_eq!(monitor.last_powered_us(), Some(off_us), "{what}: driven again");
    let again = robot.fault().await.expect("still latched");
    assert_eq!((again.fault, again.number), (report.fault, report.number), "{what}");
    robot.0.testbed.mend(breaks);
    robot.listen(100).await;
    robot.tell(Command::ClearFault { number: report.number }).await;
    Found { fault: report.fault, off_ms: off_us.saturating_sub(event_us) as f64 * 1e-3 }
}

/// Falls silent at cruise, or goes on talking without renewing; from what is heard until the first
/// telemetry that shows a controlled stop.
async fn go_silent(robot: &mut Robot, talk: bool) -> Found {
    robot.cruise(&AHEAD, 2000).await;
    let event_us = now_us();
    robot.0.session.take_telemetry().for_each(drop);
    let mut stop_us = None;
    while now_us() < event_us + 1_500_000 {
        if talk {
            let _ = robot.status().await;
        }
        robot.listen(1).await;
        let stopping = robot.0.session.take_telemetry().any(|t| t.state == State::Stopping);
        if stopping && stop_us.is_none() {
            stop_us = Some(now_us());
        }
    }
    sleep_until_us(now_us() + 1000).await;
    let report = robot.fault().await.expect("latched");
    robot.tell(Command::ClearFault { number: report.number }).await;
    let stop_us = stop_us.expect("it stopped along a ramp");
    Found { fault: report.fault, off_ms: (stop_us - event_us) as f64 * 1e-3 }
}

#[test]
fn every_fault_at_cruise_is_named_and_latched_and_the_motors_are_off_in_time() {
    let ended = emulation()
        .run(|bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            robot.tell(Command::Subscribe { period_ms: 2 }).await;
            let mut found = Vec::new();
            for case in CASES {
                found.push(break_at_cruise(&mut robot, case).await);
            }
            let silent = go_silent(&mut robot, false).await;
            let talking = go_silent(&mut robot, true).await;
            (found, silent, talking)
        })
        .unwrap();
    uneventful(&ended);
    let (found, silent, talking) = &ended.found;
    println!(
        "what breaks at cruise            named                          zero duty after   bound"
    );
    for ((what, .., bound_ms), Found { fault, off_ms }) in CASES.iter().zip(found) {
        println!("{what:<32} {:<30} {off_ms:>10.2} ms {bound_ms:>6.0} ms", fault.to_string());
    }
    println!(
        "                                                                controlled stop after"
    );
    let silences = [("host silent", silent), ("host sends, does not renew", talking)];
    for (what, Found { fault, off_ms }) in silences {
        println!("{what:<32} {:<30} {off_ms:>10.2} ms {:>6.0} ms", fault.to_string(), 250.0);
    }
    for ((what, _, expected, bound_ms), Found { fault, off_ms }) in CASES.iter().zip(found) {
        assert!(expected.contains(fault), "{what}: {fault}");
        assert!(off_ms <= bound_ms, "{what}: {off_ms} ms");
    }
    assert_eq!(silent.fault, Fault::LinkLost);
    assert_eq!(talking.fault, Fault::TimeToLive);
    for (what, Found { off_ms, .. }) in silences {
        assert!((100.0..=250.0).contains(off_ms), "{what}: {off_ms} ms");
    }
}

#[test]
fn the_button_stops_and_held_later_for_two_seconds_it_clears_its_own_fault() {
    let ended = emulation()
        .run(|bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            let motion = robot.cruise(&AHEAD, 1000).await;
            robot.0.testbed.inject(PlantFault::EmergencyStop);
            robot.renew(motion, 2500).await;
            robot.0.testbed.mend(PlantFault::EmergencyStop);
            robot.listen(500).await;
            let held_at_first = robot.status().await;
            for ms in [1900, 2100] {
                robot.0.testbed.inject(PlantFault::EmergencyStop);
                robot.listen(ms).await;
                robot.0.testbed.mend(PlantFault::EmergencyStop);
                robot.listen(500).await;
                if ms == 1900 {
                    assert!(robot.fault().await.is_some(), "too short");
                }
            }
            let held_later = robot.status().await;
            let off_us = robot.0.monitor.last_powered_us();
            robot.listen(500).await;
            assert_eq!(robot.0.monitor.last_powered_us(), off_us, "nothing moves by a button");
            (held_at_first, held_later)
        })
        .unwrap();
    uneventful(&ended);
    let (held_at_first, held_later) = ended.found;
    assert_eq!(held_at_first.fault.map(|report| report.fault), Some(Fault::EmergencyStop));
    assert_eq!((held_later.state, held_later.fault), (State::Idle, None));
}
