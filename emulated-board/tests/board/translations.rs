//! A board whose core has run other boards before is the same board, to the instruction.

use emulated_board::{Bench, Bug, Effect, Emulation, Place, forget_translations};

use super::emulation;
use super::robot::{AHEAD, Robot};

/// Who sets the PWM.
const PWM: Place = Place::Register(0x4001_003C);

/// Everything that can be observed of a short drive, which ends by a bug or by a restart.
fn life(bug: Option<Effect>) -> String {
    let ended = Emulation { count: true, ..emulation() }
        .run(move |bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            robot.0.session.save_config().await.unwrap();
            let motion = robot.cruise(&AHEAD, 300).await;
            let monitor = robot.0.monitor.clone();
            if let Some(effect) = bug {
                monitor.plant(Bug { place: PWM, effect });
                // It ends with the bug in its flash.
                robot.renew(motion, 6).await;
                return String::new();
            }
            monitor.plant(Bug { place: PWM, effect: Effect::Panic });
            robot.renew(motion, 60).await;
            robot.meet_again(2).await;
            format!("{:?} {:?}", robot.status().await, robot.0.session.identify().await.unwrap())
        })
        .unwrap();
    let of_chip = (ended.instructions, ended.lived_us, ended.resets, ended.stack, ended.unexpected);
    let of_time = (ended.tick_times, ended.ticks, ended.early);
    format!("{} {of_chip:?} {of_time:?} {:?}", ended.found, ended.flash_journal)
}

#[test]
fn a_core_that_other_boards_have_used_runs_like_a_new_one_whatever_was_in_their_flash() {
    forget_translations();
    let new = life(None);
    for effect in [Effect::Panic, Effect::Hang, Effect::HardFault] {
        life(Some(effect));
        assert!(life(None) == new, "after a life that ended with {effect:?}");
    }
}
