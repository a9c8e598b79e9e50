//! When frames get lost, is everything done exactly once?

use beeline_tests::calibration::{Instrument, verdict_on_scenario};
use beeline_tests::robot::{Snapshot, meters, on_robot, on_robot_with};
use host_link::motion::{self, RecordOptions};
use shared_proto::{
    Answer, Command, Config, Drive, MotionEnd, MotionId, Refusal, State, Telemetry, WheelPair,
    WheelTelemetry,
};
use sim_target::{Options, Scenario};

fn lossy(loss: f64, seed: u64) -> Scenario {
    let mut scenario = Scenario { seed, ..Scenario::default() };
    scenario.link.frame_loss_to_robot = loss;
    scenario.link.frame_loss_to_host = loss;
    scenario
}

/// A robot whose right wheel is smaller, as in the paper: W_T has something to say.
fn unequal(mut scenario: Scenario) -> Scenario {
    scenario.plant.geometry.wheel_radius_m = WheelPair::new(0.036, 0.0357084);
    scenario
}

#[test]
fn a_calibration_on_a_lossy_line_gives_bit_for_bit_the_same_wheel_weight() {
    // A retry shifts the drive on the robot's clock, but not the recording against the drive, and lost
    // frames of the recording are recalled: nothing can differ.
    for seed in 17..=22 {
        for instrument in [Instrument::Camera, Instrument::Ruler] {
            let clean =
                verdict_on_scenario(&unequal(lossy(0.0, seed)), instrument).expect("a good line");
            assert_eq!(clean.decision, "corrected", "seed {seed}, {instrument:?}");
            let lost = verdict_on_scenario(&unequal(lossy(0.02, seed)), instrument)
                .unwrap_or_else(|why| panic!("seed {seed}, {instrument:?}: {why}"));
            let difference = lost.wheel_weight - clean.wheel_weight;
            println!("seed {seed}, {instrument:?}: {difference:e}");
            assert_eq!(lost.wheel_weight, clean.wheel_weight, "seed {seed}, {instrument:?}");
            assert_eq!(lost.decision, clean.decision, "seed {seed}, {instrument:?}");
        }
    }
}

#[test]
fn five_times_the_loss_changes_the_wheel_weight_no_more() {
    // Some of these seeds lose four frames in a row while the robot drives.
    for (seed, instrument) in [
        (1, Instrument::Ruler),
        (7, Instrument::Camera),
        (15, Instrument::Camera),
        (60, Instrument::Ruler),
    ] {
        let clean = verdict_on_scenario(&lossy(0.0, seed), instrument).expect("a good line");
        let lost = verdict_on_scenario(&lossy(0.10, seed), instrument)
            .unwrap_or_else(|why| panic!("seed {seed}, {instrument:?}: {why}"));
        assert_eq!(lost.wheel_weight, clean.wheel_weight, "seed {seed}, {instrument:?}");
    }
}

#[test]
fn a_recording_over_a_lossy_line_holds_every_sample() {
    let record = |loss: f64, period_ms: u16| {
        on_robot(&lossy(loss, 3), async |robot| {
            let short = meters(0.3, 0.3, 0.2, 0.5);
            let options = RecordOptions { period_ms, ..RecordOptions::default() };
            let run = motion::drive(&mut robot.session, &short, options, &mut |_| ()).await;
            (run.expect("no fault").telemetry, robot.session.statistics())
        })
    };
    for (loss, period_ms) in [(0.02, 10), (0.10, 10), (0.02, 5)] {
        let ((clean, _), (lost, statistics)) = (record(0.0, period_ms), record(loss, period_ms));
        assert_eq!(clean.len(), lost.len(), "{loss}: {statistics:?}");
        let counts = |frames: &[Telemetry]| -> Vec<_> {
            let origin_us = frames[0].t_us;
            // Summed up since power-on, in which the one robot was armed longer than the other.
            let wheels = |frame: &Telemetry| {
                frame.wheels.map(|wheel| WheelTelemetry { applied_uvs: 0, ..wheel })
            };
            frames.iter().map(|frame| (frame.t_us - origin_us, wheels(frame))).collect()
        };
        assert_eq!(counts(&clean), counts(&lost), "{loss}");
        assert!(clean.is_sorted_by(|a, b| a.t_us + u64::from(period_ms) * 1000 == b.t_us));
        assert_eq!(statistics.telemetry_lost, 0, "{loss}: {statistics:?}");
        assert!(statistics.telemetry_recalled > 0, "the line lost nothing");
    }
}

#[test]
fn telemetry_can_be_recalled_for_a_while_and_is_then_forgotten() {
    on_robot(&Scenario::default(), async |robot| {
        assert_eq!(robot.ask(Command::Recall { number: 3 }).await, Err(Refusal::Forgotten));
        robot.tell(Command::Subscribe { period_ms: 10 }).await;
        robot.listen(0.1).await;
        let seen = robot.session.take_telemetry().next().expect("it was subscribed to");
        let recall = Command::Recall { number: seen.number };
        for _ in 0..2 {
            assert_eq!(robot.ask(recall.clone()).await, Ok(Answer::Telemetry(seen)));
        }
        robot.listen(0.01 * f64::from(Telemetry::KEPT)).await;
        assert_eq!(robot.ask(recall).await, Err(Refusal::Forgotten));
    });
}

#[test]
fn a_drive_begins_at_its_time_however_often_it_is_said() {
    for repeats in [1, 6] {
        on_robot(&Scenario::default(), async |robot| {
            robot.tell(Command::Arm { take: false }).await;
            let start = robot.snapshot();
            let start_us = (start.t_us / 1000 + 400) * 1000;
            let first = meters(0.2, 0.2, 0.2, 0.5).drive_now(MotionId(77));
            let drive = Drive { start_us: Some(start_us), ..first };
            for _ in 0..repeats {
                robot.tell(Command::Drive(drive)).await;
                robot.renew(drive.motion, 0.03).await;
            }
            robot.finish(drive.motion).await;
            let powered = robot.snapshots_from(start.t_us).into_iter().find(Snapshot::is_powered);
            let powered_us = powered.expect("it drove").t_us;
            // Snapshots are taken once a millisecond, and the motors get current within the tick.
            assert!((start_us..=start_us + 2000).contains(&powered_us), "{powered_us} {start_us}");
            let way = robot.snapshot().pose.relative_to(start.pose);
            assert!((0.197..0.2011).contains(&way.x_m), "{way:?}");
        });
    }
}

#[test]
fn a_time_to_set_off_that_has_passed_or_is_far_away_is_refused_and_nothing_moves() {
    on_robot(&Scenario::default(), async |robot| {
        robot.tell(Command::Arm { take: false }).await;
        let start = robot.snapshot();
        let drive = meters(0.2, 0.2, 0.2, 0.5).drive_now(MotionId(77));
        for start_us in [0, start.t_us, start.t_us + 11_000_000, u64::MAX] {
            let late = Drive { start_us: Some(start_us), ..drive };
            let refusal = Refusal::Motion(shared_proto::MotionError::Start);
            assert_eq!(robot.ask(Command::Drive(late)).await, Err(refusal), "{start_us}");
        }
        robot.listen(0.3).await;
        assert_eq!(robot.state().await, State::Armed);
        assert_eq!(robot.snapshot().moved_since_m(&start), 0.0);
        // The same motion may be ordered again, for a better time.
        let later = Drive { start_us: Some(robot.snapshot().t_us + 100_000), ..drive };
        robot.tell(Command::Drive(later)).await;
        // And while it waits, a stop ends it before it has begun.
        robot.tell(Command::Stop).await;
        robot.listen(0.3).await;
        assert_eq!(robot.state().await, State::Armed);
        assert_eq!(robot.snapshot().moved_since_m(&start), 0.0);
    });
}

#[test]
fn a_host_that_dies_while_a_motion_waits_leaves_a_named_fault_and_a_robot_that_never_moved() {
    on_robot(&Scenario::default(), async |robot| {
        robot.tell(Command::Arm { take: false }).await;
        let start = robot.snapshot();
        let drive = meters(0.2, 0.2, 0.2, 0.5).drive_now(MotionId(77));
        let drive = Drive { start_us: Some(start.t_us + 1_000_000), ..drive };
        robot.tell(Command::Drive(drive)).await;
        robot.listen(1.5).await;
        assert!(robot.fault().await.is_some());
        assert_eq!(robot.snapshot().moved_since_m(&start), 0.0);
        assert_eq!(robot.state().await, State::Faulted);
    });
}

#[test]
fn the_lossy_line_of_these_tests_does_lose_frames_both_ways() {
    on_robot(&lossy(0.1, 1), async |robot| {
        for _ in 0..300 {
            robot.state().await;
        }
        let link = robot.session.status().await.expect("it answers").link;
        let host = robot.session.statistics();
        // 10 % of some 360 frames each way, and 4 standard deviations of 6.
        assert!((12..=60).contains(&link.frames_lost), "{link:?}");
        assert!((12..=60).contains(&host.frames_lost), "{host:?}");
        assert!(host.retries > 30, "{host:?}");
    });
}

#[test]
fn the_host_renews_often_enough_for_the_shortest_link_timeout() {
    let mut config = Config::default();
    config.protection.link_timeout_s = 0.05;
    let options = Options { config: Some(config), ..Options::default() };
    on_robot_with(&Scenario::default(), options, async |robot| {
        let short = meters(0.3, 0.3, 0.2, 0.5);
        let options = RecordOptions::default();
        let run = motion::drive(&mut robot.session, &short, options, &mut |_| ()).await;
        assert_eq!(run.expect("no fault").end, MotionEnd::Completed);
    });
}

#[test]
fn a_drive_heard_twice_is_driven_once() {
    on_robot(&Scenario::default(), async |robot| {
        robot.tell(Command::Arm { take: false }).await;
        let start = robot.snapshot();
        let drive = meters(0.2, 0.2, 0.2, 0.5).drive_now(MotionId(77));
        for _ in 0..3 {
            robot.tell(Command::Drive(drive)).await;
        }
        robot.renew(drive.motion, 0.8).await;
        robot.tell(Command::Drive(drive)).await;
        robot.finish(drive.motion).await;
        // And after its end.
        robot.tell(Command::Drive(drive)).await;
        robot.listen(1.0).await;
        assert_eq!(robot.state().await, State::Armed);
        let way = robot.snapshot().pose.relative_to(start.pose);
        // The wheels are up to 0.8 % smaller than configured, and settle within two counts.
        assert!((0.197..0.2011).contains(&way.x_m), "{way:?}");
    });
}

#[test]
fn a_renewal_of_another_motion_is_refused_and_renews_nothing() {
    on_robot(&Scenario::default(), async |robot| {
        let first = robot.cruise(&meters(3.0, 3.0, 0.2, 0.5), 0.8).await;
        robot.drive(&meters(3.0, 3.0, 0.2, 0.5)).await.expect("accepted");
        let stale = Command::Renew { motion: first };
        for _ in 0..40 {
            assert_eq!(robot.ask(stale.clone()).await, Err(Refusal::NoSuchMotion));
            robot.listen(0.02).await;
        }
        let fault = robot.fault().await.expect("nobody renewed the second motion").fault;
        assert_eq!(fault, shared_proto::Fault::TimeToLive);
    });
}

#[test]
fn every_other_command_may_be_repeated_too() {
    on_robot(&Scenario::default(), async |robot| {
        let Answer::Config(config) = robot.tell(Command::ReadConfig).await else { panic!() };
        for command in [
            Command::WriteConfig(config),
            Command::SaveConfig,
            Command::Arm { take: false },
            Command::Stop,
            Command::Subscribe { period_ms: 10 },
            Command::Subscribe { period_ms: 0 },
            Command::Disarm,
        ] {
            let first = robot.ask(command.clone()).await;
            let state = robot.state().await;
            assert_eq!(robot.ask(command.clone()).await, first, "{command:?}");
            assert_eq!(first, Ok(Answer::Done), "{command:?}");
            assert_eq!(robot.state().await, state, "{command:?}");
        }
    });
}
