//! The chip itself: each revision of the silicon, and what the firmware sets in its registers before a motor
//! may move. Sections are those of RM0090.

use emulated_board::{Bench, Emulation, RegisterAccess, Revision, RunResult};
use shared_proto::{Command, Config, ConfigOrigin, Fault, Refusal, ResetCause, State};
use sim_target::{now_us, sleep_until_us};

use super::robot::{AHEAD, Robot};
use super::{emulation, uneventful};

/// Every revision of ES0206: A, Y, 1, and those from 3 on.
const REVISIONS: [Revision; 5] = [0x1000, 0x1003, 0x1007, 0x2001, 0x2003];

/// Registers by address.
const MODER_A: u64 = 0x4002_0000;
const FLASH_ACR: u64 = 0x4002_3C00;
const FLASH_OPTCR: u64 = 0x4002_3C14;
const RCC_CR: u64 = 0x4002_3800;
const DEBUG_APB1: u64 = 0xE004_2008;
const DEBUG_APB2: u64 = 0xE004_200C;
const BREAK: u64 = 0x4001_0044;
const LEFT_FILTER: u64 = 0x4000_0418;
const RIGHT_FILTER: u64 = 0x4000_0818;
const PULLS_C: u64 = 0x4002_080C;
const PULLS_D: u64 = 0x4002_0C0C;
const WATCHDOG_KEY: u64 = 0x4000_3000;
const WATCHDOG_RELOAD: u64 = 0x4000_3008;
const WATCHDOG_STATUS: u64 = 0x4000_300C;

/// Starts the board, and reads registers.
fn started(addresses: &'static [u64]) -> RunResult<Vec<u32>> {
    let ended = emulation()
        .run(move |bench: Bench| async move {
            let robot = Robot::meet(bench).await;
            robot.0.monitor.ask_registers(addresses);
            sleep_until_us(now_us() + 1000).await;
            robot.0.monitor.registers()
        })
        .unwrap();
    uneventful(&ended);
    ended
}

fn field(register: u32, bit: u32, width: u32) -> u32 {
    register >> bit & ((1 << width) - 1)
}

#[test]
fn every_revision_of_the_silicon_starts_saves_and_finds_its_configuration_again() {
    for revision in REVISIONS {
        let emulation = Emulation { revision, ..emulation() };
        let ended = emulation
            .run(|bench: Bench| async move {
                let mut robot = Robot::meet(bench).await;
                let mut config = Config::default();
                config.geometry.wheel_weight = 1.01;
                robot.tell(Command::WriteConfig(config)).await;
                robot.tell(Command::SaveConfig).await;
                robot.0.monitor.ask_registers(&[MODER_A]);
                sleep_until_us(now_us() + 1000).await;
                field(robot.0.monitor.registers()[0], 24, 2)
            })
            .unwrap_or_else(|error| panic!("{revision:#x}: {error}"));
        uneventful(&ended);
        // ES0206, 2.2.14: before revision 3, PA12 is an output, low. Later chips leave it alone.
        assert_eq!(ended.found, u32::from(revision < 0x2001), "{revision:#x}");
        let again = Emulation { flash: Some(ended.flash), ..emulation };
        let ended = again
            .run(|bench: Bench| async move {
                let mut robot = Robot::meet(bench).await;
                let identity = robot.0.session.identify().await.unwrap();
                (identity.config_origin, robot.0.session.read_config().await.unwrap())
            })
            .unwrap();
        uneventful(&ended);
        let (origin, config) = ended.found;
        assert_eq!(origin, ConfigOrigin::Saved, "{revision:#x}");
        assert_eq!(config.geometry.wheel_weight, 1.01, "{revision:#x}");
    }
}

#[test]
fn a_debuggers_halt_stops_the_pwm_and_not_only_the_watchdog() {
    let found = started(&[DEBUG_APB1, DEBUG_APB2, BREAK]).found;
    // 38.16.4 and 38.16.5; with its counter stopped, TIM1's outputs are off as if MOE were 0 (17.3.21),
    // and with OSSI off means low.
    assert_eq!(field(found[0], 12, 1), 1, "DBG_IWDG_STOP");
    assert_eq!(field(found[1], 0, 1), 1, "DBG_TIM1_STOP");
    assert_eq!(field(found[2], 10, 1), 1, "OSSI");
}

#[test]
fn an_encoder_of_5_v_meets_no_pull_up_and_a_spike_meets_a_filter() {
    let found = started(&[PULLS_C, PULLS_D, LEFT_FILTER, RIGHT_FILTER]).found;
    // 8.4.4: PC6, PC7, PD12, PD13.
    assert_eq!((field(found[0], 12, 4), field(found[1], 24, 4)), (0, 0), "no pull-up");
    // 18.4.7: eight samples at 84 MHz / 32 on both channels, 3.05 us.
    for filter in &found[2..] {
        assert_eq!((field(*filter, 4, 4), field(*filter, 12, 4)), (0b1111, 0b1111));
    }
}

#[test]
fn prefetch_and_both_caches_are_on_also_after_the_store_was_written() {
    // 3.5.2, 3.9.1
    let enabled = |acr: u32| field(acr, 8, 3);
    assert_eq!(enabled(started(&[FLASH_ACR]).found[0]), 0b111);
    let ended = emulation()
        .run(|bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            robot.tell(Command::SaveConfig).await;
            robot.0.monitor.ask_registers(&[FLASH_ACR]);
            sleep_until_us(now_us() + 1000).await;
            robot.0.monitor.registers()[0]
        })
        .unwrap();
    uneventful(&ended);
    assert_eq!(enabled(ended.found), 0b111);
}

#[test]
fn the_brown_out_level_is_the_highest_and_is_written_once() {
    // 3.9.10: level 3 is 0b00, the factory's "off" 0b11.
    let ended = started(&[FLASH_OPTCR]);
    assert_eq!(field(ended.found[0], 2, 2), 0);
    let starts = |access: &&RegisterAccess| {
        access.written && access.address == FLASH_OPTCR && access.value & 1 << 1 != 0
    };
    assert_eq!(ended.early.iter().filter(starts).count(), 1);
}

#[test]
fn the_watchdog_runs_before_the_clocks_and_is_fed_only_when_its_timeout_has_arrived() {
    let ended = started(&[RCC_CR]);
    let first = |is: &dyn Fn(&RegisterAccess) -> bool| {
        ended.early.iter().position(is).expect("it happens at the start")
    };
    let begins = first(&|a| a.written && a.address == WATCHDOG_KEY && a.value & 0xFFFF == 0xCCCC);
    let clock = first(&|a| a.written && a.address == RCC_CR && a.value & 1 << 16 != 0);
    assert!(begins < clock, "a clock that does not start hangs an unguarded chip");
    // 21.4.4: the reload value must not be used while RVU is set.
    let mut arrived = true;
    let mut fed = 0;
    for access in &ended.early {
        match (access.address, access.written) {
            (WATCHDOG_RELOAD, true) => arrived = false,
            (WATCHDOG_STATUS, false) => arrived |= access.value & 0b11 == 0,
            (WATCHDOG_KEY, true) if access.value & 0xFFFF == 0xAAAA => {
                assert!(arrived, "fed with the timeout of before");
                fed += 1;
            }
            _ => {}
        }
    }
    assert!(fed > 1);
}

#[test]
fn an_external_clock_that_stops_at_cruise_has_the_motors_off_at_once_and_the_board_restarts() {
    let ended = emulation()
        .run(|bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            let motion = robot.cruise(&AHEAD, 1500).await;
            let (event_us, monitor) = (now_us(), robot.0.monitor.clone());
            assert!(monitor.duty().all(|duty| duty > 0.05), "it drives");
            monitor.fail_clock();
            robot.renew(motion, 200).await;
            robot.meet_again(2).await;
            let cause = robot.0.session.identify().await.unwrap().reset_cause;
            let last_us = monitor.last_powered_us().unwrap_or(0);
            (cause, last_us.saturating_sub(event_us), robot.status().await.state)
        })
        .unwrap();
    assert!(ended.unexpected.is_empty(), "{:#?}", ended.unexpected);
    let (cause, powered_us, state) = ended.found;
    assert_eq!((cause, state), (ResetCause::Panic, State::Idle));
    assert!(powered_us <= 100, "{powered_us} us");
}

/// Opens the stop line at cruise for so long [us]; how long the motors were driven after it [us].
async fn open_at_cruise(robot: &mut Robot, us: u64) -> u64 {
    let motion = robot.cruise(&AHEAD, 1500).await;
    let (event_us, monitor) = (now_us(), robot.0.monitor.clone());
    assert!(monitor.duty().all(|duty| duty > 0.05), "it drives");
    monitor.open_stop_line(true);
    sleep_until_us(now_us() + us).await;
    monitor.open_stop_line(false);
    robot.renew(motion, 300).await;
    monitor.last_powered_us().unwrap_or(0).saturating_sub(event_us)
}

#[test]
fn the_stop_line_stops_the_motors_in_hardware_and_closing_it_clears_nothing() {
    let ended = emulation()
        .run(|bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            let monitor = robot.0.monitor.clone();
            let mut found = Vec::new();
            // A bounce of 200 us falls between two looks of the program at the pin.
            for us in [200, 500_000] {
                let powered_us = open_at_cruise(&mut robot, us).await;
                let report = robot.fault().await.expect("latched");
                assert!(matches!(
                    robot.ask(Command::Arm { take: false }).await,
                    Err(Refusal::Faulted(_))
                ));
                // Held open: the fault cannot be cleared.
                monitor.open_stop_line(true);
                robot.listen(20).await;
                let clear = Command::ClearFault { number: report.number };
                assert_eq!(robot.ask(clear.clone()).await, Err(Refusal::CauseRemains));
                // Closed for longer than a held button takes: still latched.
                monitor.open_stop_line(false);
                robot.listen(2500).await;
                assert!(robot.fault().await.is_some(), "closing the line cleared its fault");
                robot.tell(clear).await;
                found.push((report.fault, powered_us));
            }
            // After the reset it drives again.
            robot.cruise(&AHEAD, 1500).await;
            assert!(monitor.duty().all(|duty| duty > 0.05), "it drives again");
            robot.rest().await;
            found
        })
        .unwrap();
    uneventful(&ended);
    for (fault, powered_us) in ended.found {
        assert_eq!(fault, Fault::EmergencyStop);
        // Within a step of the plant, whatever the program does.
        assert!(powered_us <= 100, "{powered_us} us");
    }
}

#[test]
fn a_stop_line_that_was_never_wired_keeps_the_robot_from_arming() {
    let ended = emulation()
        .run(|bench: Bench| async move {
            bench.monitor.open_stop_line(true);
            let mut robot = Robot::meet(bench).await;
            robot.listen(50).await;
            let armed = robot.ask(Command::Arm { take: false }).await;
            (armed.is_ok(), robot.fault().await.map(|report| report.fault))
        })
        .unwrap();
    uneventful(&ended);
    assert_eq!(ended.found, (false, Some(Fault::EmergencyStop)));
}
