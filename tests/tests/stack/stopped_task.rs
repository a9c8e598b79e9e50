//! One safety task stops alone, without a panic and without holding the core: the robot stops all the same.

use beeline_tests::robot::{Robot, meters, on_robot};
use host_link::motion::Motion;
use shared_proto::{Command, Config, Fault, ResetCause, State, WheelPair};
use sim_target::{RobotTask, Scenario, now_us, sleep_until_us};

/// The paper's cruise, far enough for everything here.
const AHEAD: Motion =
    Motion { distance: WheelPair::both(20.0), acceleration: 0.523, ..Motion::PAPER };

/// Zero duty this long after the host fell silent \[us\].
const SILENT_US_MAX: u64 = 250_000;

/// The board is back this long after a task stopped \[us\].
const RESTART_US_MAX: u64 = 110_000;

#[test]
fn any_safety_task_may_stop_alone_and_a_silent_host_still_means_zero_duty_and_a_named_restart() {
    for task in RobotTask::SAFETY {
        on_robot(&Scenario::default(), async |robot| {
            let off_us = stop_one_and_fall_silent(robot, task).await;
            println!("{task:?} stopped, host silent: zero duty after {} ms", off_us as f64 * 1e-3);
            assert!(off_us <= SILENT_US_MAX, "{task:?}: {off_us} us");
            robot.reconnect(2).await;
            let identity = robot.session.identify().await.unwrap();
            assert_eq!(identity.reset_cause, ResetCause::Watchdog, "{task:?}");
            let status = robot.session.status().await.unwrap();
            assert_eq!((status.state, status.fault), (State::Idle, None), "{task:?}");
            // The robot's clock begins anew with the control ticks: one each millisecond.
            assert!(status.ticks < 3_000, "{task:?}: {} ticks", status.ticks);
            let id = robot.cruise(&meters(0.05, 0.05, 0.1, 0.5), 0.3).await;
            robot.finish(id).await;
            assert_eq!(robot.fault().await, None, "{task:?}: drives again");
        });
    }
}

#[test]
fn a_task_that_stops_while_the_host_renews_restarts_the_robot_as_well() {
    for task in RobotTask::SAFETY {
        on_robot(&Scenario::default(), async |robot| {
            let id = robot.cruise(&AHEAD, 2.0).await;
            let event_us = now_us();
            robot.testbed.stop_task(task);
            while now_us() < event_us + RESTART_US_MAX {
                robot.session.post(Command::Renew { motion: id }).await.unwrap();
                sleep_until_us(now_us() + 20_000).await;
            }
            // What the robot said to the host before is not for the next one.
            sleep_until_us(now_us() + 10_000).await;
            while robot.wire.read_now(&mut [0; 256]) > 0 {}
            robot.reconnect(2).await;
            let identity = robot.session.identify().await.unwrap();
            assert_eq!(identity.reset_cause, ResetCause::Watchdog, "{task:?}");
            let off_us = robot.last_powered_us(event_us).unwrap_or(event_us) - event_us;
            assert!((1..=RESTART_US_MAX).contains(&off_us), "{task:?}: {off_us} us");
        });
    }
}

#[test]
fn without_guard_and_watchdog_the_control_tick_itself_stops_a_robot_whose_supervisor_stopped() {
    for link_timeout_s in [0.1, 0.2, 0.24] {
        on_robot(&Scenario::default(), async |robot| {
            let mut config = Config::default();
            config.protection.link_timeout_s = link_timeout_s;
            robot.tell(Command::WriteConfig(config)).await;
            robot.testbed.remove_guard();
            let off_us = stop_one_and_fall_silent(robot, RobotTask::Supervisor).await;
            println!("the control tick alone: zero duty after {} ms", off_us as f64 * 1e-3);
            assert!(off_us <= SILENT_US_MAX, "{off_us} us");
            assert!(off_us as f64 * 1e-6 >= link_timeout_s.min(0.2), "no sooner: {off_us} us");
        });
    }
}

#[test]
fn the_control_tick_names_what_it_stopped() {
    // Whoever looks before the restart sees the fault: here the telemetry's state cannot change any more,
    // so the fault is read when the supervisor runs again.
    on_robot(&Scenario::default(), async |robot| {
        robot.testbed.remove_guard();
        stop_one_and_fall_silent(robot, RobotTask::Supervisor).await;
        robot.testbed.resume_tasks();
        robot.listen(0.05).await;
        let report = robot.fault().await.expect("latched");
        assert_eq!(report.fault, Fault::Unsupervised);
        assert_eq!(robot.state().await, State::Faulted);
    });
}

/// Stops a task at cruise just after the last renewal; returns when the last motor went off \[us\].
async fn stop_one_and_fall_silent(robot: &mut Robot, task: RobotTask) -> u64 {
    let id = robot.cruise(&AHEAD, 2.0).await;
    assert!(robot.snapshot().is_powered(), "{task:?}: it drives");
    robot.session.post(Command::Renew { motion: id }).await.unwrap();
    robot.listen(0.001).await;
    let event_us = now_us();
    robot.testbed.stop_task(task);
    sleep_until_us(event_us + 3_000_000).await;
    robot.last_powered_us(event_us).unwrap_or(event_us) - event_us
}
