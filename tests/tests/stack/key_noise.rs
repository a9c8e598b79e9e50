//! Random bytes and frames against a robot with a key: nothing moves, and nothing grows.

use beeline_tests::robot::on_robot_with;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared_proto::{
    Channel, Command, Encoder, FRAME_LEN_MAX, Hello, Received, Request, Seal, State,
};
use sim_target::{Scenario, now_us, sleep_until_us};

use crate::key::{ByHand, refused, with_key};

/// Something that somebody without the key may send.
fn noise(rng: &mut ChaCha8Rng, recorded: &[Vec<u8>], encoder: &mut Encoder) -> Vec<u8> {
    let mut bytes = [0; FRAME_LEN_MAX];
    let len = rng.random_range(0..64);
    rng.fill_bytes(&mut bytes[..len]);
    let channel = Channel::from_number(rng.random_range(0..7)).expect("a channel");
    let seal =
        rng.random_bool(0.7).then(|| Seal { counter: rng.random_range(0..300), tag: rng.random() });
    match rng.random_range(0..6) {
        0 => bytes[..len].to_vec(),
        1 => encoder.hello(Hello::of_this_build(rng.random_range(0..4))).to_vec(),
        2 => {
            let mut frame = recorded[rng.random_range(0..recorded.len())].clone();
            let at = rng.random_range(0..frame.len());
            frame[at] ^= 1 << rng.random_range(0..8);
            frame
        }
        3 => recorded[rng.random_range(0..recorded.len())].clone(),
        // A request as the robot would obey it, but for its seal.
        4 => {
            let commands = [
                Command::Arm { take: true },
                Command::EmergencyStop,
                Command::Disarm,
                Command::SetKey { key: None },
                Command::Stop,
            ];
            let command = commands[rng.random_range(0..commands.len())].clone();
            let until_ms = now_us() / 1000 + 200;
            let request =
                Request { session: rng.random_range(1..4), id: rng.random(), until_ms, command };
            let plain = Encoder::new().message(&request).to_vec();
            let mut decoder = shared_proto::Decoder::new();
            let mut forged = plain.clone();
            for byte in plain {
                if let Some(Ok(frame)) = decoder.push(byte) {
                    forged = encoder.relay(&Received { seal, ..frame }).to_vec();
                }
            }
            forged
        }
        _ => encoder.relay(&Received { channel, lost: 0, payload: &bytes[..len], seal }).to_vec(),
    }
}

/// Memory of this process \[KiB\], where the system tells.
fn memory_kib() -> u64 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    statm.split(' ').nth(1).and_then(|pages| pages.parse::<u64>().ok()).unwrap_or(0) * 4
}

fn attack(frames: u32, seed: u64) {
    let scenario = Scenario {
        link: sim_target::scenario::LinkParameters { baud: 0, ..Scenario::default().link },
        ..Scenario::default()
    };
    on_robot_with(&scenario, with_key(), async |robot| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut host = ByHand::open(&robot.wire, 2).await;
        let mut recorded = Vec::new();
        for command in [
            Command::Arm { take: false },
            Command::EmergencyStop,
            Command::Status,
            Command::Disarm,
            Command::ClearFault { number: 1 },
        ] {
            let frame = host.frame(command);
            robot.wire.write_now(&frame);
            sleep_until_us(now_us() + 30_000).await;
            recorded.push(frame);
        }
        robot.listen(0.1).await;
        robot.tell(Command::Arm { take: false }).await;
        let (stands, before) = (robot.snapshot(), refused(robot).await);
        let mut encoder = Encoder::new();
        let mut memory = Vec::new();
        for number in 0..frames {
            robot.wire.write_now(&noise(&mut rng, &recorded, &mut encoder));
            if number % 64 == 0 {
                // Whoever is not there: the robot's replies to nobody are taken off the line.
                robot.listen(0.002).await;
            }
            if number % 1000 == 0 {
                robot.forget_snapshots();
                assert_eq!(
                    (robot.state().await, robot.fault().await),
                    (State::Armed, None),
                    "{number}"
                );
            }
            if number % (frames / 10) == 0 {
                memory.push(memory_kib());
            }
        }
        assert_eq!((robot.state().await, robot.fault().await), (State::Armed, None));
        assert!(robot.snapshot().moved_since_m(&stands) < 1e-6);
        let refused = refused(robot).await - before;
        println!("{frames} frames, {refused} refused; memory {memory:?} KiB");
        assert!(refused > frames / 4, "{refused}");
    });
}

#[test]
fn a_hundred_thousand_random_frames_move_nothing() {
    attack(100_000, 16);
}

/// `cargo test -p beeline-tests --test stack --release -- --ignored --nocapture ten_million`
#[test]
#[ignore = "takes minutes"]
fn ten_million_random_frames_move_nothing() {
    attack(10_000_000, 17);
}
