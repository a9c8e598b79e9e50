//! The pre-shared key: who holds it drives; whoever does not, or repeats what was said before, moves nothing.

use std::cell::RefCell;
use std::rc::Rc;

use beeline_tests::robot::{Robot, meters, on_robot, on_robot_with, own_secret};
use futures_lite::future;
use host_link::wire::Waiting;
use host_link::{Error, Motion, Session, Wire};
use shared_proto::{
    Answer, Channel, Command, Decoder, Encoder, Hello, Key, Open, Received, Refusal, Reply,
    Request, State,
};
use sim_link::{RecordedWire, SimWire};
use sim_target::{HostWire, Options, Scenario, now_us, sleep_until_us};

pub const KEY: Key = Key::new(*b"a key of a test.");
pub const OTHER: Key = Key::new(*b"a key of a test!");

/// Farther than any of these goes.
pub fn ahead() -> Motion {
    meters(5.0, 5.0, 0.2, 1.0)
}

pub fn with_key() -> Options {
    Options { key: Some(KEY), random: Some([7; 32]), ..Options::default() }
}

/// A host that speaks the protocol by hand.
pub struct ByHand {
    wire: HostWire,
    number: u32,
    encoder: Encoder,
    decoder: Decoder,
    session_key: Key,
    counter: u64,
    /// What showed the key.
    opened_by: Vec<u8>,
}

impl ByHand {
    /// One that has shown the key.
    pub async fn open(wire: &HostWire, number: u32) -> Self {
        let (mut encoder, mut decoder) = (Encoder::new(), Decoder::new());
        let hello = Hello::of_this_build(number);
        wire.write_now(&encoder.hello(hello));
        let challenge = loop {
            let challenge = hear(wire, &mut decoder, |frame| frame.challenge()).await;
            if let Some(challenge) = challenge {
                break challenge;
            }
        };
        let nonce = own_secret(number).host_nonce(0);
        let session_key = KEY.of_session(&hello.to_bytes(), &nonce, &challenge);
        let opened_by = encoder.open(Open { session: number, nonce }, &session_key).to_vec();
        wire.write_now(&opened_by);
        while hear(wire, &mut decoder, |frame| frame.opened()).await.is_none() {}
        Self { wire: wire.clone(), number, encoder, decoder, session_key, counter: 0, opened_by }
    }

    /// A sealed frame with the next counter; commands have a lease.
    pub fn frame(&mut self, command: Command) -> Vec<u8> {
        self.counter += 1;
        let until_ms = if command.needs_lease() { now_us() / 1000 + 200 } else { 0 };
        let id = self.counter as u32;
        let request = Request { session: self.number, id, until_ms, command };
        self.encoder.sealed_message(&request, Some((&self.session_key, self.counter))).to_vec()
    }

    pub fn send(&mut self, command: Command) {
        let frame = self.frame(command);
        self.wire.write_now(&frame);
    }

    /// The reply to the last request, if it comes within 20 ms.
    async fn reply(&mut self) -> Option<Reply> {
        let until_us = now_us() + 20_000;
        let id = self.counter as u32;
        let replied = async {
            loop {
                let reply =
                    hear(&self.wire, &mut self.decoder, |frame| frame.message::<Reply>()).await;
                if let Some(reply) = reply.filter(|reply| reply.id == id) {
                    return Some(reply);
                }
            }
        };
        let timeout = async {
            sleep_until_us(until_us).await;
            None
        };
        future::or(replied, timeout).await
    }
}

/// Looks at the frames that arrive next.
pub async fn hear<T>(
    wire: &HostWire,
    decoder: &mut Decoder,
    look: impl Fn(&Received<'_>) -> Option<T>,
) -> Option<T> {
    let mut byte = [0];
    loop {
        wire.read(&mut byte).await;
        if let Some(Ok(frame)) = decoder.push(byte[0]) {
            return look(&frame);
        }
    }
}

/// How many frames the robot has refused.
pub async fn refused(robot: &mut Robot) -> u32 {
    robot.session.status().await.expect("it answers").link.frames_refused
}

/// Puts a recording host with this number in the place of the robot's session.
async fn record(robot: &mut Robot, number: u32) -> Rc<RefCell<Vec<Vec<u8>>>> {
    let sent = Rc::new(RefCell::new(Vec::new()));
    let wire = RecordedWire(SimWire(robot.wire.clone()), sent.clone());
    robot.session = Session::new(wire, robot.session.clock(), number, "recorded".into());
    robot.session.use_key(KEY, own_secret(number));
    robot.session.open().await.expect("the key is right");
    sent
}

#[test]
fn who_holds_the_key_drives_and_everybody_else_is_told_why_not() {
    for random in [None, Some([7; 32])] {
        on_robot_with(&Scenario::default(), Options { random, ..with_key() }, async |robot| {
            let id = robot.cruise(&meters(0.05, 0.05, 0.1, 0.5), 0.1).await;
            robot.finish(id).await;
            assert!(robot.snapshot().pose.x_m > 0.045);
            for (number, key) in (50..).zip([None, Some(OTHER)]) {
                let expected = |error: &Error| match key {
                    None => matches!(error, Error::KeyNeeded { .. }),
                    Some(_) => matches!(error, Error::WrongKey { .. }),
                };
                let mut stranger = sim_link::session(&robot.wire, number, "sim");
                if let Some(key) = key {
                    stranger.use_key(key, own_secret(number));
                }
                let error = stranger.open().await.expect_err("it does not hold the key");
                assert!(expected(&error), "{error}");
                let error = stranger.emergency_stop().await.expect_err("nor may it stop the robot");
                assert!(expected(&error), "{error}");
            }
            assert_eq!((robot.state().await, robot.fault().await), (State::Armed, None));
        });
    }
    on_robot(&Scenario::default(), async |robot| {
        let mut host = sim_link::session(&robot.wire, 9, "sim");
        host.use_key(KEY, own_secret(9));
        let error = host.open().await.expect_err("this robot has no key");
        assert!(matches!(error, Error::RobotWithoutKey { .. }), "{error}");
        host.offer_key(KEY, own_secret(9));
        host.open().await.expect("it will do");
    });
}

#[test]
fn every_frame_of_a_drive_sent_again_moves_and_stops_nothing_now_later_and_after_a_restart() {
    on_robot_with(&Scenario::default(), with_key(), async |robot| {
        let sent = record(robot, 2).await;
        let id = robot.cruise(&meters(0.05, 0.05, 0.1, 0.5), 0.1).await;
        robot.finish(id).await;
        robot.tell(Command::Stop).await;
        robot.tell(Command::Disarm).await;
        robot.session.emergency_stop().await.expect("it stops");
        let report = robot.fault().await.expect("latched");
        robot.tell(Command::ClearFault { number: report.number }).await;
        let recorded: Vec<_> = sent.borrow().clone();
        assert!(recorded.len() > 8, "{}", recorded.len());
        for situation in ["the same session", "the next session", "after a restart", "again"] {
            match situation {
                "the same session" => {}
                "the next session" => drop(robot.another_host(3).await),
                "after a restart" => {
                    robot.testbed.restart_controller();
                    sleep_until_us(now_us() + 100_000).await;
                    drop(robot.another_host(4).await);
                }
                // The number of the recorded session.
                _ => drop(robot.another_host(2).await),
            }
            let id = robot.cruise(&ahead(), 0.5).await;
            let before = refused(robot).await;
            for frames in &recorded {
                robot.wire.write_now(frames);
                robot.renew(id, 0.02).await;
            }
            assert_eq!(
                (robot.state().await, robot.fault().await),
                (State::Driving, None),
                "{situation}"
            );
            let after = refused(robot).await;
            println!("{situation}: {} of {} refused", after - before, recorded.len());
            robot.tell(Command::Disarm).await;
            robot.listen(1.0).await;
            let stands = robot.snapshot();
            recorded.iter().for_each(|frames| robot.wire.write_now(frames));
            robot.listen(1.0).await;
            assert_eq!(
                (robot.state().await, robot.fault().await),
                (State::Idle, None),
                "{situation}"
            );
            assert!(robot.snapshot().moved_since_m(&stands) < 1e-6, "{situation}");
        }
    });
}

#[test]
fn a_frame_that_was_held_back_is_dropped_once_a_later_one_has_come() {
    on_robot_with(&Scenario::default(), with_key(), async |robot| {
        let mut host = ByHand::open(&robot.wire, 2).await;
        let arm = host.frame(Command::Arm { take: false });
        host.send(Command::Status);
        assert!(host.reply().await.is_some());
        let before = refused(robot).await;
        robot.wire.write_now(&arm);
        robot.wire.write_now(&arm);
        sleep_until_us(now_us() + 20_000).await;
        assert_eq!((robot.state().await, refused(robot).await), (State::Idle, before + 2));
        host.send(Command::Arm { take: false });
        sleep_until_us(now_us() + 20_000).await;
        assert_eq!(robot.state().await, State::Armed);
    });
}

#[test]
fn no_flipped_bit_and_no_other_sessions_number_makes_a_frame_that_is_obeyed() {
    on_robot_with(&Scenario::default(), with_key(), async |robot| {
        let mut host = ByHand::open(&robot.wire, 2).await;
        let mut other = ByHand::open(&robot.wire, 3).await;
        let before = refused(robot).await;
        let mut forged = 0;
        let mut encoder = Encoder::new();
        for command in [Command::Arm { take: true }, Command::EmergencyStop] {
            let frame = host.frame(command);
            let mut decoder = Decoder::new();
            for byte in frame {
                let Some(Ok(frame)) = decoder.push(byte) else { continue };
                let seal = frame.seal.expect("sealed");
                let bits = 8 * frame.payload.len();
                for bit in 0..bits + 128 {
                    let (mut payload, mut seal) = (frame.payload.to_vec(), seal);
                    match bit.checked_sub(bits) {
                        None => payload[bit / 8] ^= 1 << (bit % 8),
                        Some(bit @ 0..64) => seal.counter ^= 1 << bit,
                        Some(bit) => seal.tag[bit / 8 - 8] ^= 1 << (bit % 8),
                    }
                    let seal = Some(seal);
                    robot.wire.write_now(&encoder.relay(&Received {
                        payload: &payload,
                        seal,
                        ..frame
                    }));
                    sleep_until_us(now_us() + 1000).await;
                    forged += 1;
                }
                // From one session into the other: its number is the payload's first byte.
                let mut payload = frame.payload.to_vec();
                payload[0] = 3;
                robot.wire.write_now(&encoder.relay(&Received { payload: &payload, ..frame }));
                forged += 1;
            }
        }
        // Whatever one session said, as an answer to the challenge of another.
        robot.wire.write_now(&host.opened_by);
        robot.wire.write_now(&other.opened_by);
        robot.listen(0.1).await;
        assert_eq!((robot.state().await, robot.fault().await), (State::Idle, None));
        println!("{} of {forged} counted as refused", refused(robot).await - before);
        assert!(refused(robot).await - before > forged / 2);
        other.send(Command::Status);
        assert!(other.reply().await.is_some(), "sessions that are meddled with go on");
        host.send(Command::Status);
        assert!(host.reply().await.is_some());
    });
}

/// A line whose far end is somebody who repeats what a robot said before.
struct Impostor(Rc<RefCell<Vec<u8>>>);

impl Wire for Impostor {
    fn write<'a>(&'a mut self, _: &'a [u8]) -> Waiting<'a, std::io::Result<()>> {
        Box::pin(async { Ok(()) })
    }

    fn read(&mut self) -> Waiting<'_, std::io::Result<Vec<u8>>> {
        Box::pin(async move {
            sleep_until_us(now_us() + 1000).await;
            let mut said = self.0.borrow_mut();
            let len = said.len().min(100);
            Ok(said.drain(..len).collect())
        })
    }
}

#[test]
fn a_host_believes_no_answer_that_the_robot_did_not_give_it() {
    on_robot_with(&Scenario::default(), with_key(), async |robot| {
        // What the robot says to a host that opens a session and stops it.
        let clock = robot.session.clock();
        let mut host = ByHand::open(&robot.wire, 2).await;
        host.send(Command::EmergencyStop);
        let mut said = Vec::new();
        let (mut encoder, mut decoder) = (Encoder::new(), Decoder::new());
        let hello = encoder.challenge(Hello::of_this_build(2), [3; 16]).to_vec();
        sleep_until_us(now_us() + 20_000).await;
        let mut buffer = [0; 1024];
        let len = robot.wire.read_now(&mut buffer);
        let heard = buffer[..len].iter().any(|&byte| {
            matches!(decoder.push(byte), Some(Ok(frame)) if frame.channel == Channel::Reply)
        });
        assert!(heard, "the robot's own answer is among it");
        // Beside it, answers that nobody has sealed, to all that the host may ask.
        for id in 0..50 {
            let reply = Reply { session: 2, id, t_us: now_us(), outcome: Ok(Answer::Done) };
            said.extend(encoder.message(&reply).to_vec());
            said.extend(
                encoder.sealed_message(&reply, Some((&OTHER, u64::from(id) + 1000))).to_vec(),
            );
        }
        let played = [hello.as_slice(), &buffer[..len], &said].concat().repeat(3);
        let mut victim =
            Session::new(Impostor(Rc::new(RefCell::new(played))), clock, 2, "impostor".into());
        victim.use_key(KEY, own_secret(77));
        let error = victim.emergency_stop().await.expect_err("nobody has stopped");
        assert!(matches!(error, Error::NoAnswer { .. }), "{error}");
        assert!(victim.open().await.is_err());
        assert!(victim.statistics().frames_refused > 50, "{:?}", victim.statistics());
    });
}

#[test]
fn observers_with_the_key_watch_the_one_driver() {
    on_robot_with(&Scenario::default(), with_key(), async |robot| {
        let mut driver = robot.another_host(2).await;
        std::mem::swap(&mut driver, &mut robot.session);
        robot.tell(Command::Subscribe { period_ms: 20 }).await;
        let id = robot.cruise(&ahead(), 0.5).await;
        let mut watcher = driver;
        std::mem::swap(&mut watcher, &mut robot.session);
        let mut driver = watcher;
        assert_eq!(robot.ask(Command::Subscribe { period_ms: 5 }).await, Err(Refusal::Driven));
        robot.session.overhear();
        for _ in 0..10 {
            driver.post(Command::Renew { motion: id }).await.expect("sent");
            driver.post(Command::Subscribe { period_ms: 20 }).await.expect("sent");
            robot.listen(0.05).await;
        }
        assert!(robot.session.take_telemetry().count() > 10);
        let arm = robot.ask(Command::Arm { take: false }).await;
        assert_eq!(arm, Err(Refusal::Driven));
    });
}
