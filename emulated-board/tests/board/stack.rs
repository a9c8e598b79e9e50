//! How deep the stack gets, and what happens if it gets too deep.

use emulated_board::{Bench, Bug, Effect, Emulation, Place};
use shared_proto::{Command, ResetCause, State};
use sim_target::now_us;

use super::emulation;
use super::paper::calibrated;
use super::robot::{AHEAD, Robot};

/// A board whose stack is guarded, as the real one's is.
fn with_guard() -> Emulation {
    Emulation { mpu: true, ..emulation() }
}

/// The deepest that boot, a calibration, a save and a fault may need: half of what there is.
const SHARE_MAX: f64 = 0.5;

#[test]
fn boot_calibration_save_and_fault_take_at_most_half_of_the_stack() {
    let calibrated = calibrated();
    let ended = Emulation { flash: Some(calibrated.flash.clone()), ..with_guard() }
        .run(|bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            robot.0.session.save_config().await.unwrap();
            robot.cruise(&AHEAD, 500).await;
            robot.tell(Command::EmergencyStop).await;
            robot.status().await.fault
        })
        .unwrap();
    assert!(ended.found.is_some(), "a fault is latched");
    let used = ended.stack.used.max(calibrated.stack.used);
    let share = used as f64 / ended.stack.size as f64;
    println!("{used} of {} bytes of stack", ended.stack.size);
    // Less than the frame of one exception would be no measurement.
    assert!(ended.stack.used > 500 && calibrated.stack.used > 500, "{:?}", ended.stack);
    assert!(share <= SHARE_MAX, "{used} of {}", ended.stack.size);
}

#[test]
fn a_stack_overflow_overwrites_no_static_and_has_the_motors_off_and_the_board_back() {
    let ended = with_guard()
        .run(|bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            let motion = robot.cruise(&AHEAD, 1500).await;
            let monitor = robot.0.monitor.clone();
            assert!(monitor.duty().all(|duty| duty > 0.05), "it drives");
            let event_us = now_us();
            // The task that watches the button.
            let place = Place::Register(0x4002_0810);
            monitor.plant(Bug { place, effect: Effect::StackOverflow });
            robot.renew(motion, 200).await;
            let resets_us = monitor.resets_us();
            let powered_us = monitor.last_powered_us().unwrap_or(0).saturating_sub(event_us);
            robot.meet_again(2).await;
            let cause = robot.0.session.identify().await.unwrap().reset_cause;
            let status = robot.status().await;
            (resets_us.len(), powered_us, cause, status.state, status.fault)
        })
        .unwrap();
    let (resets, powered_us, cause, state, fault) = ended.found;
    println!("motors off after {powered_us} us, {cause:?}");
    assert_eq!((resets, state, fault), (1, State::Idle, None));
    assert_eq!(cause, ResetCause::Panic);
    // The task is asleep for up to 5 ms.
    assert!(powered_us <= 6000, "{powered_us} us");
    // The last push of nine words had no room.
    assert!(ended.stack.used + 36 > ended.stack.size, "{:?}", ended.stack);
    assert!(ended.unexpected.is_empty(), "{:#?}", ended.unexpected);
}
