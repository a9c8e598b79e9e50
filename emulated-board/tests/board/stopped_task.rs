//! One safety task stops alone, or the core stands still for a while: on the flashed image.

use emulated_board::{Bench, Bug, Effect, Place};
use shared_proto::{Command, ResetCause, State, WheelPair};
use sim_target::{now_us, sleep_until_us};

use super::robot::{AHEAD, Robot};
use super::{emulation, uneventful};

/// The tasks on which safety depends, beside control.
const TASKS: [&str; 6] =
    ["supervisor", "receive", "transmit", "emergency_stop", "driver_fault", "heartbeat"];

/// Zero duty this long after the host fell silent \[ms\].
const SILENT_MS_MAX: f64 = 250.0;

/// Stops a task just after the host's last word; returns when the motors were off and the board restarted.
async fn stop_alone(robot: &mut Robot, task: &'static str, number: u32) -> (f64, f64, ResetCause) {
    let motion = robot.cruise(&AHEAD, 1500).await;
    robot.0.session.post(Command::Renew { motion }).await.unwrap();
    robot.listen(2).await;
    let monitor = robot.0.monitor.clone();
    assert!(monitor.duty().all(|duty| duty > 0.05), "{task}: it drives");
    let (event_us, resets) = (now_us(), monitor.resets_us().len());
    monitor.plant(Bug { place: Place::Task(task), effect: Effect::Stop });
    sleep_until_us(event_us + 600_000).await;
    let resets_us = monitor.resets_us();
    assert_eq!(resets_us.len(), resets + 1, "{task}: one restart");
    robot.meet_again(number).await;
    let cause = robot.0.session.identify().await.unwrap().reset_cause;
    let status = robot.status().await;
    assert_eq!((status.state, status.fault), (State::Idle, None), "{task}: back at rest");
    let ms = |t_us: u64| t_us.saturating_sub(event_us) as f64 * 1e-3;
    (monitor.last_powered_us().map_or(0.0, ms), ms(resets_us[resets]), cause)
}

#[test]
fn a_safety_task_that_stops_alone_has_the_motors_off_and_the_board_restarted() {
    let ended = emulation()
        .run(|bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            let mut found = Vec::new();
            for (number, task) in TASKS.into_iter().enumerate() {
                found.push(stop_alone(&mut robot, task, 2 + number as u32).await);
            }
            found
        })
        .unwrap();
    assert!(ended.unexpected.is_empty(), "{:#?}", ended.unexpected);
    println!("stops alone, host silent         zero duty after   restart after   reported as");
    for (task, (off_ms, restart_ms, cause)) in TASKS.iter().zip(&ended.found) {
        let cause = format!("{cause:?}").to_lowercase();
        println!("{task:<32} {off_ms:>12.2} ms {restart_ms:>12.2} ms   {cause}");
    }
    for (task, &(off_ms, restart_ms, cause)) in TASKS.iter().zip(&ended.found) {
        assert!(off_ms <= SILENT_MS_MAX, "{task}: {off_ms} ms");
        assert!(off_ms <= restart_ms && restart_ms <= SILENT_MS_MAX, "{task}: {restart_ms} ms");
        assert_eq!(cause, ResetCause::Watchdog, "{task}");
    }
}

#[test]
fn a_core_that_stood_still_at_rest_loses_ticks_and_arms_and_drives_all_the_same() {
    let ended = emulation()
        .run(|bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            let mut lost = Vec::new();
            // The last four of different lengths, so that one ends while the clock's timer passes a half of its range.
            for ms in [2, 20, 17, 18, 19, 20] {
                let before = robot.status().await.ticks_lost;
                let stall = Effect::Stall { ms };
                robot.0.monitor.plant(Bug { place: Place::Task("heartbeat"), effect: stall });
                robot.listen(100).await;
                let after = robot.status().await;
                assert!(after.t_us <= now_us(), "its clock is not ahead of its power");
                lost.push((ms, after.ticks_lost - before));
                robot.cruise(&AHEAD, 500).await;
                assert_eq!(robot.fault().await, None, "after {ms} ms");
                assert!(robot.0.monitor.duty() != WheelPair::both(0.0), "after {ms} ms: it drives");
                robot.rest().await;
            }
            lost
        })
        .unwrap();
    uneventful(&ended);
    for (ms, lost) in ended.found {
        println!("a stall of {ms} ms: {lost} ticks lost");
        // A tick a millisecond, of which the timer's flag keeps the last; one more where the stall ends on a tick.
        let expected = u32::from(ms) - 1;
        assert!((expected..=expected + 1).contains(&lost), "{lost} ticks in {ms} ms");
    }
}
