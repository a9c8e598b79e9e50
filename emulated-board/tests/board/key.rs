//! A board with a key: who holds it drives, and whoever does not, or repeats what was said, moves nothing.

use std::cell::RefCell;
use std::rc::Rc;

use emulated_board::Bench;
use host_link::error::Error;
use host_link::session::Session;
use shared_proto::{Key, State};
use sim_link::{RecordedWire, SimWire};
use sim_target::plant::Pose;
use sim_target::{now_us, sleep_until_us};

use super::emulation;
use super::robot::{AHEAD, Robot};

const KEY: Key = Key::new(*b"a key of a test.");
const OTHER: Key = Key::new(*b"a key of a test!");

/// What a host of this number draws its nonces from.
fn secret(number: u32) -> Key {
    Key::new(std::array::from_fn(|i| number.to_le_bytes()[i % 4] ^ i as u8))
}

type Frames = Rc<RefCell<Vec<Vec<u8>>>>;

/// A host that holds the key takes the place of the one before, and is recorded.
async fn holder(robot: &mut Robot, number: u32) -> Frames {
    let sent = Frames::default();
    let wire = RecordedWire(SimWire(robot.0.wire.clone()), sent.clone());
    let clock = robot.0.session.clock();
    robot.0.session = Session::new(wire, clock, number, "recorded".into());
    robot.0.session.use_key(KEY, secret(number));
    robot.0.session.open().await.expect("it holds the key");
    sent
}

async fn is_refused(robot: &Robot, number: u32, key: Option<Key>, why: impl Fn(&Error) -> bool) {
    let mut stranger = robot.0.session(number);
    if let Some(key) = key {
        stranger.use_key(key, secret(number));
    }
    let error = stranger.open().await.expect_err("it does not hold the key");
    assert!(why(&error), "{error}");
    let error = stranger.emergency_stop().await.expect_err("nor may it stop the robot");
    assert!(why(&error), "{error}");
}

/// Sends all of it again, and tells how many frames were refused.
async fn replay(robot: &mut Robot, sent: &[Vec<u8>]) -> u32 {
    let before = robot.status().await;
    for frame in sent {
        robot.0.wire.write_now(frame);
        sleep_until_us(now_us() + 10_000).await;
    }
    let after = robot.status().await;
    assert_eq!((after.state, after.fault), (State::Idle, None));
    after.link.frames_refused - before.link.frames_refused
}

fn way_m(from: Pose, to: Pose) -> f64 {
    (to.x_m - from.x_m).hypot(to.y_m - from.y_m)
}

#[test]
fn a_board_with_a_key_obeys_who_holds_it_and_neither_strangers_nor_what_was_said_before() {
    let ended = emulation()
        .run(|bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            robot.0.session.set_key(Some(KEY), secret(1)).await.expect("it had none");
            let sent = holder(&mut robot, 2).await;
            let start = robot.0.testbed.pose();
            robot.cruise(&AHEAD, 1500).await;
            robot.rest().await;
            let stood = robot.0.testbed.pose();
            let driven_m = way_m(start, stood);
            assert!(driven_m > 0.05, "a holder drives: {driven_m} m");
            let sent = sent.borrow().clone();
            // Hellos are answered, and the answer to a challenge is refused in a later session.
            let requests = sent.len() as u32 - 2;

            is_refused(&robot, 3, None, |error| matches!(error, Error::KeyNeeded { .. })).await;
            is_refused(&robot, 4, Some(OTHER), |error| matches!(error, Error::WrongKey { .. }))
                .await;
            let mut refused = vec![replay(&mut robot, &sent).await];
            // With a generator of random numbers, then without: only the count of starts differs.
            for number in [5, 6] {
                robot.0.monitor.pull_reset();
                sleep_until_us(now_us() + 100_000).await;
                holder(&mut robot, number).await;
                refused.push(replay(&mut robot, &sent).await);
                robot.0.monitor.break_random();
            }
            (requests, refused, way_m(stood, robot.0.testbed.pose()))
        })
        .unwrap();
    assert_eq!(ended.resets, 2, "those that were asked for");
    assert!(ended.unexpected.is_empty(), "{:#?}", ended.unexpected);
    let (requests, refused, moved_m) = ended.found;
    println!("{requests} requests sent again, refused: {refused:?}");
    assert!(requests > 10 && moved_m < 1e-4, "{requests} requests, {moved_m} m");
    assert!(refused.iter().all(|&refused| refused >= requests), "{refused:?} of {requests}");
}
