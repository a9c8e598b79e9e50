//! What the flashed image finds in its flash, and when it leaves it alone.

use emulated_board::{Bench, blank};
use shared_proto::{Command, Config, ConfigOrigin, Name, Refusal, State};

use super::robot::{AHEAD, Robot};
use super::{emulation, uneventful};

/// What an image that wrote the first layout of the store left in its flash.
const LAYOUT_1: &[u8] = include_bytes!("../../../firmware/tests/store/layout_1.bin");

fn layout_1() -> Vec<u8> {
    let mut flash = blank();
    flash[..LAYOUT_1.len()].copy_from_slice(LAYOUT_1);
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
    // What that layout lacked has been inserted between its values, and all of these are kept.
    let mut saved = Config { name: Name::new("numbered").unwrap(), ..Config::default() };
    saved.geometry.wheel_weight = 1.0 + 8.0 * 0.123_456_789e-6;
    (saved.geometry.heading_pull_rad_per_m, saved.limits.hold_s) = (0.0, 0.0);
    (saved.feedforward.supply_v, saved.protection.supply_v_max) = (0.0, 0.0);
    assert_eq!(older.2, saved);
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
            robot.tell(Command::Arm { take: false }).await;
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
