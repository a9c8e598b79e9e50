//! What the flashed image finds in its flash, and when it leaves it alone.

use emulated_board::{Bench, blank};
use shared_proto::{Command, Config, ConfigOrigin, Name, Refusal, State};

use super::robot::{AHEAD, Robot};
use super::{emulation, uneventful};

/// What an image that wrote the first layout of the store left in its flash; see
/// `firmware/tests/store/layouts.rs`.
const LAYOUT_1: &str = "00000000082a82f3cc0059fc010100d5943a83086e756d62657265643bdf4f8d976ea23f022b8716\
    d9ced73f67161f090100f03f0000000000208c40000000000000f03f000000000000208c40000000\
    000000f03f00000000000000000044400000000000004e40000000000000f03f7b14ae47e17aa43f\
    0000000000000040fca9f1d24d62b03f9a9999999999d93f000000000000f03f000000000000e03f\
    000000000000f03f00000000000034407b14ae47e17a943fb81e85eb51b8ae3f000000000000d03f\
    00000000000022409a9999999999c93f";

fn layout_1() -> Vec<u8> {
    let digit = |byte: u8| (byte as char).to_digit(16).expect("hexadecimal") as u8;
    let pairs = LAYOUT_1.as_bytes().chunks_exact(2);
    let mut flash = blank();
    flash
        .iter_mut()
        .zip(pairs)
        .for_each(|(byte, pair)| *byte = digit(pair[0]) << 4 | digit(pair[1]));
    flash
}

#[test]
fn an_older_layout_is_read_and_a_damaged_store_boots_with_defaults_and_says_so() {
    let mut damaged = layout_1();
    // Every sector marked as full, and no record in any.
    let sector = damaged.len() / 4;
    for sector in damaged.chunks_exact_mut(sector) {
        sector.fill(0);
    }
    let ended = emulation()
        .run(|bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            let mut found = Vec::new();
            for (number, flash) in [layout_1(), damaged, blank()].into_iter().enumerate() {
                robot.0.monitor.power_cycle(flash);
                sim_target::sleep_until_us(sim_target::now_us() + 100_000).await;
                robot.meet_again(2 + number as u32).await;
                let identity = robot.0.session.identify().await.unwrap();
                let config = robot.0.session.read_config().await.unwrap();
                // Whatever it found, it takes a new one.
                robot.0.session.save_config().await.unwrap();
                found.push((identity.config_origin, identity.store_damaged, config));
            }
            found
        })
        .unwrap();
    let [older, damaged, blank] = &ended.found[..] else { panic!("three boots") };
    assert_eq!((older.0, older.1), (ConfigOrigin::Saved, false));
    assert_eq!(older.2.name, Name::new("numbered").unwrap());
    assert_eq!(older.2.geometry.wheel_weight, 1.0 + 8.0 * 0.123_456_789e-6);
    assert_eq!(
        (damaged.0, damaged.1, &damaged.2),
        (ConfigOrigin::Factory, true, &Config::default())
    );
    assert_eq!((blank.0, blank.1, &blank.2), (ConfigOrigin::Factory, false, &Config::default()));
}

#[test]
fn the_flash_is_left_alone_while_the_robot_is_armed_or_moves() {
    let ended = emulation()
        .run(|bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            robot.tell(Command::Arm).await;
            let armed = robot.ask(Command::SaveConfig).await;
            let motion = robot.cruise(&AHEAD, 1000).await;
            let driving = robot.ask(Command::SaveConfig).await;
            robot.tell(Command::Stop).await;
            let stopping = robot.ask(Command::SaveConfig).await;
            robot.renew(motion, 1000).await;
            robot.rest().await;
            [armed, driving, stopping]
        })
        .unwrap();
    uneventful(&ended);
    let states = [State::Armed, State::Driving, State::Stopping];
    assert_eq!(ended.found, states.map(|state| Err(Refusal::State(state))));
    assert_eq!(ended.flash_operations, 0);
}
