//! Frames get lost: nothing is done twice, and nothing is left undone.

use beeline_tests::judge::{Eye, judge_scenario};
use beeline_tests::robot::{TTL_MS, meters, on_robot, on_robot_with, with_id};
use host_cli::motion::{self, RecordOptions};
use shared_proto::{Answer, Command, Config, MotionEnd, MotionId, Refusal, State};
use sim_target::{Options, Scenario};

fn lossy(loss: f64, seed: u64) -> Scenario {
    let mut scenario = Scenario { seed, ..Scenario::default() };
    scenario.link.frame_loss_to_robot = loss;
    scenario.link.frame_loss_to_host = loss;
    scenario
}

#[test]
fn a_calibration_on_a_lossy_line_gives_bit_for_bit_the_same_wheel_weight() {
    // Some of these seeds lose four frames in a row while the robot drives.
    for seed in [1, 7, 15, 60] {
        // The ruler reads once a run, so a retry shifts the run in time and changes nothing else: same
        // placement, same counts, same mark on the ruler.
        let clean = judge_scenario(&lossy(0.0, seed), Eye::Ruler).expect("a good line");
        for loss in [0.02, 0.10] {
            let lost = judge_scenario(&lossy(loss, seed), Eye::Ruler)
                .unwrap_or_else(|why| panic!("seed {seed}, loss {loss}: {why}"));
            assert_eq!(lost.wheel_weight, clean.wheel_weight, "seed {seed}, loss {loss}");
            assert_eq!(lost.decision, clean.decision, "seed {seed}, loss {loss}");
        }
    }
}

#[test]
fn a_camera_calibration_on_a_lossy_line_differs_by_the_cameras_noise_alone() {
    let clean = judge_scenario(&lossy(0.0, 1), Eye::Camera).expect("a good line");
    let lost = judge_scenario(&lossy(0.02, 1), Eye::Camera).expect("a lossy line");
    // The retries shift the run against the camera's shutter, so its noise is drawn anew: two draws
    // differ by sqrt(2) sigma, 3 of which are a chance of 1 in 370 at most.
    let difference_sigmas = (lost.wheel_weight - clean.wheel_weight) / clean.sigma;
    assert!(difference_sigmas.abs() < 3.0 * 2.0_f64.sqrt(), "{difference_sigmas}");
    assert_ne!(lost.wheel_weight, clean.wheel_weight, "the line lost nothing");
    assert_eq!((clean.decision, lost.decision), ("corrected", "corrected"));
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
    let options = Options { flash: None, config: Some(config) };
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
        robot.tell(Command::Arm).await;
        let start = robot.look();
        let drive = with_id(&meters(0.2, 0.2, 0.2, 0.5), MotionId(77));
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
        let way = robot.look().pose.relative_to(start.pose);
        // The wheels are up to 0.8 % smaller than the robot believes, and settle within two counts.
        assert!((0.197..0.2011).contains(&way.x_m), "{way:?}");
    });
}

#[test]
fn a_renewal_of_another_motion_is_refused_and_renews_nothing() {
    on_robot(&Scenario::default(), async |robot| {
        let first = robot.cruise(&meters(3.0, 3.0, 0.2, 0.5), 0.8).await;
        robot.drive(&meters(3.0, 3.0, 0.2, 0.5)).await.expect("accepted");
        let stale = Command::Renew { motion: first, ttl_ms: TTL_MS };
        for _ in 0..40 {
            assert_eq!(robot.ask(stale.clone()).await, Err(Refusal::NoSuchMotion));
            robot.listen(0.02).await;
        }
        let fault = robot.fault().await.expect("nobody renewed the second motion").fault;
        assert_eq!(fault, shared_proto::Fault::TimeToLive);
    });
}

#[test]
fn a_time_to_live_outside_its_bounds_is_refused() {
    on_robot(&Scenario::default(), async |robot| {
        robot.tell(Command::Arm).await;
        let drive = with_id(&meters(1.0, 1.0, 0.2, 0.5), MotionId(5));
        for ttl_ms in [0, 19, 10_001, u16::MAX] {
            let answer = robot.ask(Command::Drive(shared_proto::Drive { ttl_ms, ..drive })).await;
            assert_eq!(answer, Err(Refusal::Motion(shared_proto::MotionError::TimeToLive)));
        }
        assert_eq!(robot.state().await, State::Armed);
        robot.tell(Command::Drive(drive)).await;
        let renew = Command::Renew { motion: drive.motion, ttl_ms: 0 };
        assert!(matches!(robot.ask(renew).await, Err(Refusal::Motion(_))));
    });
}

#[test]
fn every_other_command_may_be_repeated_too() {
    on_robot(&Scenario::default(), async |robot| {
        let Answer::Config(config) = robot.tell(Command::ReadConfig).await else { panic!() };
        for command in [
            Command::WriteConfig(config),
            Command::SaveConfig,
            Command::Arm,
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
