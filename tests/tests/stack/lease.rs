//! Leases: what arrives late moves nothing, however it was held up; one host drives, every host may stop.

use beeline_tests::robot::{Robot, meters, on_robot};
use futures_lite::future;
use host_link::clock::TimeSource;
use host_link::wire::Waiting;
use host_link::{Clock, Motion, Session};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared_proto::{
    Answer, Channel, Command, Decoder, Encoder, Fault, MotionId, Refusal, Request, State,
};
use sim_link::SimWire;
use sim_target::{Scenario, now_us, sleep_until_us};

use crate::safety::begins_to_stop_us;

/// Farther than any of these goes.
fn ahead() -> Motion {
    meters(5.0, 5.0, 0.2, 1.0)
}

/// A frame as the host with session 1 might have sent it.
fn frame(encoder: &mut Encoder, command: Command, until_ms: u64) -> Vec<u8> {
    encoder.message(&Request { session: 1, id: 4000, until_ms, command }).to_vec()
}

/// What lies in a buffer between a dead host and its robot.
#[derive(Clone, Copy, Debug)]
enum Queue {
    /// Renewals as the host sent them while it lived.
    Renewals,
    /// The same, with questions in between: the line never falls silent.
    RenewalsAndQuestions,
    /// Renewals, and the beginning of the motion again and again.
    Drives,
    /// Anything.
    Garbage,
}

/// Puts bytes on the line to the robot, as a bridge does whose host is gone: in pieces, at the line's speed.
fn hold_back(robot: &Robot, queue: Queue, motion: MotionId, len: usize, rng: &mut ChaCha8Rng) {
    let mut encoder = Encoder::new();
    // The host was alive until now, so that is from when its last leases are.
    let until_ms = robot.session.lease_end_ms();
    let mut piece = Vec::new();
    while piece.len() < 1000 {
        let renew = Command::Renew { motion };
        match queue {
            Queue::Renewals => piece.extend(frame(&mut encoder, renew, until_ms)),
            Queue::RenewalsAndQuestions => {
                piece.extend(frame(&mut encoder, renew, until_ms));
                piece.extend(frame(&mut encoder, Command::Status, 0));
            }
            Queue::Drives => {
                piece.extend(frame(&mut encoder, renew, until_ms));
                let again = MotionId(rng.random());
                for command in [
                    Command::ClearFault { number: 1 },
                    Command::Arm { take: true },
                    Command::Drive(ahead().drive_now(again)),
                ] {
                    piece.extend(frame(&mut encoder, command, until_ms));
                }
            }
            Queue::Garbage => piece.push(rng.random()),
        }
    }
    for _ in 0..len / piece.len() {
        robot.wire.write_now(&piece);
    }
}

#[test]
fn a_robot_whose_host_died_stops_within_250_ms_whatever_is_queued() {
    let mut rng = ChaCha8Rng::seed_from_u64(15);
    let mut latest_ms = 0;
    for case in 0..1000 {
        let queue =
            [Queue::Renewals, Queue::RenewalsAndQuestions, Queue::Drives, Queue::Garbage][case % 4];
        // From nothing to 16 MB, as many small ones as large ones.
        let len = (rng.random_range(0.0..24.0_f64).exp2() - 1.0) as usize;
        let cruise_s = rng.random_range(1.0..1.5);
        on_robot(&Scenario::default(), async |robot| {
            let motion = robot.cruise(&ahead(), cruise_s).await;
            let event_us = now_us();
            hold_back(robot, queue, motion, len, &mut rng);
            sleep_until_us(event_us + 1_200_000).await;
            let begins_us = begins_to_stop_us(&robot.snapshots_from(event_us), 0.2) - event_us;
            assert!(begins_us <= 250_000, "case {case}, {queue:?}, {len} bytes: {begins_us} us");
            latest_ms = latest_ms.max(begins_us / 1000);
            let stands = robot.snapshot();
            sleep_until_us(now_us() + 500_000).await;
            let moved_m = robot.snapshot().moved_since_m(&stands);
            assert!(moved_m < 1e-4, "case {case}, {queue:?}, {len} bytes: {moved_m} m");
        });
    }
    println!("begins to stop after {latest_ms} ms at the latest");
}

/// A host whose clock runs at another rate than the robot's: in the simulator both are one.
#[derive(Clone, Copy)]
struct Skewed(f64);

impl TimeSource for Skewed {
    fn now_us(&self) -> u64 {
        (now_us() as f64 * self.0) as u64 + 3_000_000
    }

    fn sleep_until_us(&self, t_us: u64) -> Waiting<'_, ()> {
        let at_us = (t_us.saturating_sub(3_000_000) as f64 / self.0).ceil() as u64;
        Box::pin(sleep_until_us(at_us))
    }

    fn is_virtual(&self) -> bool {
        true
    }
}

#[test]
fn a_host_whose_clock_runs_wrong_drives_and_its_robot_stops_in_time_all_the_same() {
    for rate in [0.5, 0.95, 0.999, 1.001, 1.05, 2.0] {
        on_robot(&Scenario::default(), async |robot| {
            let clock = Clock::new(Skewed(rate));
            let wire = SimWire(robot.wire.clone());
            robot.session = Session::new(wire, clock, 2, "skewed".into());
            robot.session.open().await.expect("the robot answers");
            let id = robot.cruise(&ahead(), 6.0).await;
            assert_eq!(
                (robot.state().await, robot.fault().await),
                (State::Driving, None),
                "{rate}"
            );
            robot.session.post(Command::Renew { motion: id }).await.expect("sent");
            let event_us = now_us();
            sleep_until_us(event_us + 1_500_000).await;
            let begins_us = begins_to_stop_us(&robot.snapshots_from(event_us), 0.2) - event_us;
            println!("rate {rate}: {} ms", begins_us / 1000);
            assert!((50_000..=250_000).contains(&begins_us), "{rate}: {begins_us}");
        });
    }
}

#[test]
fn every_frame_of_a_drive_sent_again_later_moves_nothing() {
    on_robot(&Scenario::default(), async |robot| {
        // A host that records what it sends.
        let mut encoder = Encoder::new();
        let motion = MotionId(77);
        let mut sent = Vec::new();
        for (command, lease) in [
            (Command::Arm { take: false }, true),
            (Command::Drive(meters(0.05, 0.05, 0.1, 0.5).drive_now(motion)), true),
            (Command::Status, false),
        ] {
            let until_ms = if lease { now_us() / 1000 + 200 } else { 0 };
            sent.push(frame(&mut encoder, command, until_ms));
        }
        for _ in 0..60 {
            let until_ms = now_us() / 1000 + 200;
            sent.push(frame(&mut encoder, Command::Renew { motion }, until_ms));
            robot.wire.write_now(&sent[sent.len() - 1]);
            if sent.len() == 4 {
                sent[..3].iter().for_each(|frame| robot.wire.write_now(frame));
            }
            robot.listen(0.03).await;
        }
        robot.finish(motion).await;
        robot.tell(Command::Disarm).await;
        let stands = robot.snapshot();
        assert!(stands.pose.x_m > 0.045, "it drove: {:?}", stands.pose);
        for frame in &sent {
            robot.wire.write_now(frame);
        }
        robot.listen(2.0).await;
        assert_eq!(robot.state().await, State::Idle);
        assert!(robot.snapshot().moved_since_m(&stands) < 1e-6);
    });
}

#[test]
fn a_lease_that_has_ended_or_ends_too_late_is_refused_and_changes_nothing() {
    on_robot(&Scenario::default(), async |robot| {
        robot.listen(1.0).await;
        assert_eq!(robot.state().await, State::Idle);
        let now_ms = robot.session.lease_end_ms() - 200;
        for (until_ms, refusal) in [
            (0, Refusal::Late),
            (now_ms - 5, Refusal::Late),
            (now_ms + 10_100, Refusal::Lease),
            (u64::MAX, Refusal::Lease),
        ] {
            let arm = Command::Arm { take: false };
            let id = robot.session.post_until(arm, until_ms).await.expect("sent");
            robot.listen(0.02).await;
            let answer = robot.session.answer_to(id).expect("the robot answers");
            assert_eq!(answer, Err(refusal), "until {until_ms} at {now_ms}");
            assert_eq!(robot.state().await, State::Idle);
        }
    });
}

#[test]
fn only_the_driver_changes_anything_and_every_host_may_stop() {
    on_robot(&Scenario::default(), async |robot| {
        robot.tell(Command::Subscribe { period_ms: 20 }).await;
        let id = robot.cruise(&ahead(), 1.0).await;
        let mut driver = robot.another_host(2).await;
        for command in [
            Command::Arm { take: false },
            Command::Drive(ahead().drive_now(MotionId(5))),
            Command::Renew { motion: id },
            Command::ClearFault { number: 1 },
            Command::Subscribe { period_ms: 0 },
            Command::SaveConfig,
            Command::RestoreConfig(shared_proto::ConfigOrigin::Factory),
        ] {
            assert_eq!(robot.ask(command.clone()).await, Err(Refusal::Driven), "{command:?}");
        }
        let config = robot.session.read_config().await.expect("everybody may read");
        let write = Command::WriteConfig(config);
        assert_eq!(robot.ask(write).await, Err(Refusal::Driven));
        assert_eq!(robot.state().await, State::Driving);
        assert_eq!(robot.ask(Command::Stop).await, Ok(Answer::Done));
        for _ in 0..20 {
            driver.post(Command::Status).await.expect("sent");
            robot.listen(0.05).await;
        }
        assert_eq!((robot.state().await, robot.fault().await), (State::Armed, None));
        // The driver is still the driver, until it or somebody else switches the motors off.
        assert_eq!(robot.ask(Command::Arm { take: false }).await, Err(Refusal::Driven));
        robot.tell(Command::Disarm).await;
        robot.tell(Command::Arm { take: false }).await;
        robot.session = driver;
        let drive = Command::Drive(ahead().drive_now(MotionId(6)));
        assert_eq!(robot.ask(drive).await, Err(Refusal::Driven), "it is the other's now");
    });
}

#[test]
fn an_armed_robot_whose_driver_died_is_anybodys_after_a_second_and_idle_after_a_stop() {
    on_robot(&Scenario::default(), async |robot| {
        robot.tell(Command::Arm { take: false }).await;
        let _dead = robot.another_host(2).await;
        assert_eq!(robot.ask(Command::Arm { take: false }).await, Err(Refusal::Driven));
        robot.listen(1.1).await;
        robot.tell(Command::Arm { take: false }).await;
        let id = robot.cruise(&meters(0.05, 0.05, 0.1, 0.5), 0.3).await;
        robot.finish(id).await;
        let _dead = robot.another_host(3).await;
        robot.tell(Command::Disarm).await;
        assert_eq!(robot.state().await, State::Idle);
        robot.tell(Command::Arm { take: false }).await;
    });
}

#[test]
fn a_stop_needs_no_hello_but_all_else_does() {
    on_robot(&Scenario::default(), async |robot| {
        robot.cruise(&ahead(), 1.0).await;
        let mut encoder = Encoder::new();
        let now_ms = now_us() / 1000;
        for command in [Command::Disarm, Command::Renew { motion: MotionId(1) }] {
            let request = Request { session: 99, id: 1, until_ms: now_ms + 200, command };
            robot.wire.write_now(&encoder.message(&request));
        }
        sleep_until_us(now_us() + 10_000).await;
        assert!(robot.snapshot().is_powered());
        let event_us = now_us();
        let stop = Command::EmergencyStop;
        let request = Request { session: 99, id: 2, until_ms: 0, command: stop };
        robot.wire.write_now(&encoder.message(&request));
        sleep_until_us(event_us + 100_000).await;
        assert!(robot.last_powered_us(event_us).unwrap_or(event_us) < event_us + 10_000);
    });
}

#[test]
fn whoever_said_no_hello_arms_nothing_although_others_said_one() {
    on_robot(&Scenario::default(), async |robot| {
        // Nobody drives: that is no reason to refuse it.
        for take in [false, true] {
            let until_ms = now_us() / 1000 + 200;
            let request = Request { session: 99, id: 1, until_ms, command: Command::Arm { take } };
            robot.wire.write_now(&Encoder::new().message(&request));
            sleep_until_us(now_us() + 10_000).await;
            assert_eq!(robot.state().await, State::Idle, "take: {take}");
        }
        robot.tell(Command::Arm { take: false }).await;
        assert_eq!(robot.state().await, State::Armed);
    });
}

#[test]
fn a_host_that_takes_over_ends_the_motion_of_the_other_with_its_lease() {
    on_robot(&Scenario::default(), async |robot| {
        let id = robot.cruise(&ahead(), 1.0).await;
        let event_us = now_us();
        let mut driver = robot.another_host(2).await;
        robot.tell(Command::Arm { take: true }).await;
        for _ in 0..20 {
            // The other one does not know yet.
            driver.post(Command::Renew { motion: id }).await.expect("sent");
            robot.state().await;
            robot.listen(0.03).await;
        }
        let begins_us = begins_to_stop_us(&robot.snapshots_from(event_us), 0.2) - event_us;
        assert!((20_000..=250_000).contains(&begins_us), "{begins_us}");
        assert_eq!(robot.fault().await.map(|report| report.fault), Some(Fault::TimeToLive));
    });
}

/// The robot stood armed, and its driver was silent for so long that it was anybody's.
#[test]
fn who_armed_a_robot_that_was_anybodys_is_its_driver_at_once() {
    on_robot(&Scenario::default(), async |robot| {
        robot.tell(Command::Arm { take: false }).await;
        robot.listen(1.2).await;
        // The second host arms; and before another word of it the first one drives.
        let first = robot.another_host(2).await;
        assert_eq!(robot.ask(Command::Arm { take: false }).await, Ok(Answer::Done));
        robot.session = first;
        let drive = Command::Drive(ahead().drive_now(MotionId(5)));
        assert_eq!(robot.ask(drive).await, Err(Refusal::Driven));
    });
}

#[test]
fn hosts_that_say_hello_often_do_not_push_the_driver_out() {
    on_robot(&Scenario::default(), async |robot| {
        let id = robot.cruise(&ahead(), 1.0).await;
        for number in 2..12 {
            let driver = robot.another_host(number).await;
            robot.state().await;
            robot.session = driver;
            robot.renew(id, 0.1).await;
        }
        assert_eq!((robot.state().await, robot.fault().await), (State::Driving, None));
    });
}

#[test]
fn an_emergency_stop_overtakes_a_flood_within_100_ms() {
    on_robot(&Scenario::default(), async |robot| {
        let id = robot.cruise(&ahead(), 1.0).await;
        let wire = robot.wire.clone();
        let mut other = sim_link::session(&robot.wire, 2, "sim");
        // The driver's host has gone mad: it renews, and fills the line with questions.
        let flood = async {
            let mut encoder = Encoder::new();
            loop {
                let until_ms = now_us() / 1000 + 200;
                let renew = frame(&mut encoder, Command::Renew { motion: id }, until_ms);
                let question = frame(&mut encoder, Command::Status, 0);
                while wire.has_room() {
                    wire.write_now(&renew);
                    wire.write_now(&question);
                }
                sleep_until_us(now_us() + 200).await;
            }
        };
        let stop = async {
            sleep_until_us(now_us() + 300_000).await;
            assert!(robot.snapshot().is_powered());
            let event_us = now_us();
            // On this line every answer to it may be lost.
            let _ = other.emergency_stop().await;
            sleep_until_us(now_us() + 500_000).await;
            let off_us = robot.last_powered_us(event_us).unwrap_or(event_us) - event_us;
            println!("off after {off_us} us");
            assert!(off_us <= 100_000, "{off_us}");
        };
        future::or(stop, flood).await;
    });
}

#[test]
fn an_answer_reaches_the_host_that_asked() {
    on_robot(&Scenario::default(), async |robot| {
        // A request of a session that never said hello, and of one that did, in one breath.
        let mut encoder = Encoder::new();
        for session in [99, 1] {
            let request = Request { session, id: 50, until_ms: 0, command: Command::Status };
            robot.wire.write_now(&encoder.message(&request));
        }
        sleep_until_us(now_us() + 20_000).await;
        let (mut buffer, mut decoder) = ([0; 1024], Decoder::new());
        let len = robot.wire.read_now(&mut buffer);
        let mut answers = Vec::new();
        for &byte in &buffer[..len] {
            if let Some(Ok(frame)) = decoder.push(byte)
                && frame.channel == Channel::Reply
            {
                let reply: shared_proto::Reply = frame.message().expect("a reply");
                answers.push((reply.session, reply.id, reply.outcome.is_ok()));
            }
        }
        assert_eq!(answers, [(99, 0, false), (1, 50, true)]);
    });
}
