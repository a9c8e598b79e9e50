//! Velocities: followed without a jump, limited in acceleration, and over with their lease.

use std::f64::consts::TAU;

use beeline_tests::robot::{Robot, meters, on_robot};
use futures_lite::future;
use host_link::Error;
use host_link::motion::{Twist, drive_at};
use shared_proto::{Command, MotionEnd, MotionError, MotionId, Refusal, State, Velocity, Wheel};
use sim_target::plant::PlantFault;
use sim_target::{Scenario, now_us, sleep_until_us};

use crate::long_counts::with_counts;
use crate::motion::{check_no_jump, fast_line};
use crate::safety::begins_to_stop_us;

const MOTION: MotionId = MotionId(9);

pub fn velocity(forward_mps: f64, turn_rad_s: f64) -> Velocity {
    Velocity { motion: MOTION, forward_mps, turn_rad_s, acceleration_mps2: 0.5 }
}

/// Commands a velocity every `period_s` for a time \[s\].
pub async fn drive(robot: &mut Robot, period_s: f64, s: f64, wanted: impl Fn(f64) -> Velocity) {
    let start_us = now_us();
    loop {
        let elapsed_s = (now_us() - start_us) as f64 * 1e-6;
        if elapsed_s >= s {
            return;
        }
        robot.session.post(Command::Velocity(wanted(elapsed_s))).await.expect("sent");
        robot.listen(period_s).await;
    }
}

#[test]
fn an_encoder_that_dies_while_the_robot_stands_at_velocity_zero_does_not_let_its_wheel_run() {
    for counts_per_rev in [200.0, 900.0, 1920.0, 8000.0] {
        for stands_s in [1.0, 1.3, 1.7] {
            let (scenario, config) = with_counts(counts_per_rev);
            let rolled_m = on_robot(&scenario, async |robot| {
                robot.session.write_config(&config).await.expect("valid");
                robot.tell(Command::Arm { take: false }).await;
                drive(robot, 0.05, 2.0, |_| velocity(0.05, 0.1)).await;
                drive(robot, 0.05, stands_s, |_| velocity(0.0, 0.0)).await;
                let before = robot.snapshot();
                robot.testbed.inject(PlantFault::EncoderUnplugged(Wheel::Left));
                drive(robot, 0.05, 60.0, |_| velocity(0.0, 0.0)).await;
                robot.snapshot().rolled_m.left - before.rolled_m.left
            });
            println!("{counts_per_rev} counts, {stands_s} s: {:.1} mm", rolled_m * 1e3);
            // The integral summed an error of less than a count until it turned the wheel: metres.
            assert!(rolled_m.abs() < 0.005, "{counts_per_rev} counts: {rolled_m} m");
        }
    }
}

#[test]
fn interference_at_rest_leaves_nothing_behind_that_stops_the_next_drive() {
    for counts_per_rev in [1920.0, 8000.0] {
        for rate in [500.0, 6000.0] {
            for seed in 0..6 {
                let (mut scenario, config) = with_counts(counts_per_rev);
                scenario.seed = seed;
                on_robot(&scenario, async |robot| {
                    robot.session.write_config(&config).await.expect("valid");
                    robot.tell(Command::Arm { take: false }).await;
                    drive(robot, 0.05, 1.0, |_| velocity(0.05, 0.0)).await;
                    drive(robot, 0.05, 0.6, |_| velocity(0.0, 0.0)).await;
                    for half in 0..9 {
                        let rate = if half % 2 == 0 { rate } else { -rate };
                        robot.testbed.inject(PlantFault::EncoderNoise(Wheel::Left, rate));
                        drive(robot, 0.05, 0.05, |_| velocity(0.0, 0.0)).await;
                    }
                    robot.testbed.inject(PlantFault::EncoderNoise(Wheel::Left, 0.0));
                    drive(robot, 0.05, 0.3, |_| velocity(0.0, 0.0)).await;
                    if let Some(report) = robot.fault().await {
                        robot.tell(Command::ClearFault { number: report.number }).await;
                    } else {
                        robot.tell(Command::Disarm).await;
                        robot.listen(1.0).await;
                    }
                    let id = robot.cruise(&meters(0.05, 0.05, 0.05, 0.2), 0.5).await;
                    robot.finish(id).await;
                    let fault = robot.fault().await.map(|report| report.fault);
                    assert_eq!(fault, None, "{counts_per_rev} counts, {rate}/s, seed {seed}");
                });
            }
        }
    }
}

#[test]
fn a_velocity_drives_its_circle_and_ends_along_a_ramp_with_its_lease() {
    on_robot(&Scenario::default(), async |robot| {
        robot.tell(Command::Arm { take: false }).await;
        // Past the encoder check and the ramp.
        drive(robot, 0.05, 2.0, |_| velocity(0.15, 0.6)).await;
        let start = robot.snapshot();
        drive(robot, 0.05, 4.0, |_| velocity(0.15, 0.6)).await;
        let way = robot.snapshot().pose.relative_to(start.pose);
        // Wheels 0.8 % apart turn the robot by 3 mrad/s, as W_T is 1 here.
        let turned_rad = way.heading_rad.rem_euclid(TAU);
        assert!((turned_rad - 2.4).abs() < 0.03, "{turned_rad}");
        let chord_m = way.x_m.hypot(way.y_m);
        let expected_m = 2.0 * 0.15 / 0.6 * (0.5_f64 * 2.4).sin();
        assert!((chord_m / expected_m - 1.0).abs() < 0.015, "{chord_m} {expected_m}");

        let event_us = now_us();
        robot.listen(1.5).await;
        let begins_us = begins_to_stop_us(&robot.snapshots_from(event_us), 0.15) - event_us;
        assert!((100_000..=250_000).contains(&begins_us), "{begins_us}");
        let status = robot.session.status().await.expect("it answers");
        let found = (status.state, status.motion_end, status.fault);
        assert_eq!(found, (State::Armed, Some(MotionEnd::Stopped), None), "no fault, and armed");
        // What comes under the old name is over; a new one drives.
        let again = Command::Velocity(velocity(0.1, 0.0));
        assert_eq!(robot.ask(again).await, Err(Refusal::NoSuchMotion));
        let new = Velocity { motion: MotionId(10), ..velocity(0.1, 0.0) };
        robot.tell(Command::Velocity(new)).await;
        assert_eq!(robot.state().await, State::Driving);
    });
}

#[test]
fn a_velocity_whose_host_falls_silent_just_ends_whatever_silence_is_permitted() {
    for link_timeout_s in [0.05, 0.1, 0.199, 0.2, 0.201, 0.24] {
        for period_s in [0.02, 0.031, 0.043] {
            on_robot(&Scenario::default(), async |robot| {
                let mut config = robot.session.read_config().await.expect("it answers");
                config.protection.link_timeout_s = link_timeout_s;
                robot.session.write_config(&config).await.expect("valid");
                robot.tell(Command::Arm { take: false }).await;
                drive(robot, period_s, 3.0, |_| velocity(0.15, 0.6)).await;
                robot.listen(1.5).await;
                let status = robot.session.status().await.expect("it answers");
                let found = (status.state, status.motion_end, status.fault);
                let expected = (State::Armed, Some(MotionEnd::Stopped), None);
                assert_eq!(found, expected, "{link_timeout_s} s, every {period_s} s");
            });
        }
    }
}

#[test]
fn velocities_change_without_a_jump_however_fast_they_come() {
    for period_s in [0.002, 0.005, 0.012, 0.03, 0.1] {
        on_robot(&fast_line(), async |robot| {
            robot.tell(Command::Subscribe { period_ms: 1 }).await;
            robot.tell(Command::Arm { take: false }).await;
            // Forward, backward, turning, and still in between; each command differs from the last.
            let wanted = |t: f64| velocity(0.2 * (1.7 * t).sin(), (2.3 * t).cos());
            drive(robot, period_s, 6.0, wanted).await;
            let status = robot.session.status().await.expect("it answers");
            assert_eq!((status.state, status.fault), (State::Driving, None), "{period_s}");
            let telemetry: Vec<_> = robot.session.take_telemetry().collect();
            let largest = check_no_jump(&telemetry, 0.5);
            assert!(largest > 0.3, "{period_s}: {largest} m/s^2");
            // And they are followed: the setpoints have the speed that was wanted 40 ms before at the latest.
            let speeds: Vec<f64> = telemetry
                .windows(2)
                .map(|w| {
                    let way_um =
                        w[1].wheels.zip(w[0].wheels).map(|(b, a)| b.setpoint_um - a.setpoint_um);
                    0.5 * (way_um.left + way_um.right) as f64 * 1e-3
                })
                .collect();
            let fastest = speeds.iter().copied().fold(0.0, f64::max);
            assert!((0.18..0.21).contains(&fastest), "{period_s}: {fastest} m/s");
        });
    }
}

#[test]
fn at_zero_velocity_the_robot_holds_its_place_and_goes_on_from_there() {
    on_robot(&Scenario::default(), async |robot| {
        robot.tell(Command::Arm { take: false }).await;
        drive(robot, 0.05, 1.5, |_| velocity(0.0, 0.0)).await;
        drive(robot, 0.05, 2.0, |_| velocity(0.1, 0.0)).await;
        drive(robot, 0.05, 1.0, |_| velocity(0.0, 0.0)).await;
        let stands = robot.snapshot();
        assert!(stands.pose.x_m > 0.1, "{:?}", stands.pose);
        drive(robot, 0.05, 3.0, |_| velocity(0.0, 0.0)).await;
        let moved_m = robot.snapshot().moved_since_m(&stands);
        // One count of the encoder.
        assert!(moved_m < 2.6e-4, "{moved_m}");
        drive(robot, 0.05, 1.0, |_| velocity(-0.1, 0.0)).await;
        let back_m = stands.pose.x_m - robot.snapshot().pose.x_m;
        assert!((0.06..0.1).contains(&back_m), "{back_m}");
    });
}

#[test]
fn a_stop_from_anywhere_ends_a_velocity_that_is_still_commanded() {
    on_robot(&Scenario::default(), async |robot| {
        robot.tell(Command::Arm { take: false }).await;
        drive(robot, 0.03, 1.5, |_| velocity(0.2, 0.0)).await;
        let mut driver = robot.another_host(2).await;
        robot.tell(Command::Stop).await;
        let event_us = now_us();
        for _ in 0..40 {
            driver.post(Command::Velocity(velocity(0.2, 0.0))).await.expect("sent");
            robot.listen(0.03).await;
        }
        assert!(
            begins_to_stop_us(&robot.snapshots_from(event_us - 50_000), 0.2) < event_us + 50_000
        );
        assert_eq!((robot.state().await, robot.fault().await), (State::Armed, None));
    });
}

#[test]
fn a_velocity_beyond_the_limits_is_refused_and_the_one_before_stays() {
    on_robot(&Scenario::default(), async |robot| {
        robot.tell(Command::Arm { take: false }).await;
        drive(robot, 0.05, 1.5, |_| velocity(0.1, 0.0)).await;
        for (wrong, error) in [
            (velocity(5.0, 0.0), MotionError::TooFast),
            (velocity(0.1, 40.0), MotionError::TooFast),
            (velocity(f64::NAN, 0.0), MotionError::NotPositive),
            (velocity(0.1, f64::INFINITY), MotionError::NotPositive),
            (Velocity { acceleration_mps2: 0.0, ..velocity(0.1, 0.0) }, MotionError::NotPositive),
            (Velocity { acceleration_mps2: 50.0, ..velocity(0.1, 0.0) }, MotionError::TooSteep),
        ] {
            let answer = robot.ask(Command::Velocity(wrong)).await;
            assert_eq!(answer, Err(Refusal::Motion(error)), "{wrong:?}");
        }
        assert_eq!(robot.state().await, State::Driving);
        // A drive has the number of its own: a velocity cannot take its place under the same one.
        let drive = meters(1.0, 1.0, 0.1, 0.5).drive_now(MotionId(11));
        robot.tell(Command::Drive(drive)).await;
        let same = Velocity { motion: MotionId(11), ..velocity(0.1, 0.0) };
        assert_eq!(robot.ask(Command::Velocity(same)).await, Err(Refusal::NoSuchMotion));
    });
}

#[test]
fn a_host_drives_at_velocities_from_start_to_standstill() {
    on_robot(&Scenario::default(), async |robot| {
        // A quarter circle to the left, then straight.
        let mut wanted = |t: f64| match t {
            0.0..5.0 => Some(Twist { forward_mps: 0.1, turn_rad_s: 0.25 }),
            5.0..8.0 => Some(Twist { forward_mps: 0.1, turn_rad_s: 0.0 }),
            _ => None,
        };
        drive_at(&mut robot.session, 0.2, &mut wanted).await.expect("it drives");
        let status = robot.session.status().await.expect("it answers");
        assert_eq!(status.motion_end, Some(MotionEnd::Stopped));
        let pose = robot.snapshot().pose;
        // The encoder check takes half a second of the first five.
        assert!((0.9..1.4).contains(&pose.heading_rad), "{pose:?}");
        assert!(pose.x_m.hypot(pose.y_m) > 0.6, "{pose:?}");
        assert_eq!((robot.state().await, robot.fault().await), (State::Idle, None));
    });
}

#[test]
fn a_host_that_slept_says_that_the_robot_stopped_by_itself_and_blames_nobody() {
    on_robot(&Scenario::default(), async |robot| {
        let begun_us = now_us();
        let mut twist = |_| Some(Twist { forward_mps: 0.15, turn_rad_s: 0.0 });
        let mut driven = Box::pin(drive_at(&mut robot.session, 0.5, &mut twist));
        let awake = async {
            sleep_until_us(begun_us + 2_000_000).await;
            None
        };
        let ended = future::or(async { Some(driven.as_mut().await) }, awake).await;
        assert!(ended.is_none(), "it drives: {ended:?}");
        // Nobody asks the drive to go on.
        sleep_until_us(begun_us + 3_500_000).await;
        let ended = driven.await;
        let Err(Error::NotRenewed { silent_s }) = ended else { panic!("{ended:?}") };
        assert!((1.4..1.7).contains(&silent_s), "{silent_s}");
    });
}
