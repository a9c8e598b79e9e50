//! A task that hangs, a panic, a hard fault: the motors are off in time, the board restarts and says why.

use emulated_board::{Bench, Bug, Effect, Place};
use shared_proto::{ResetCause, State};
use sim_target::now_us;

use super::emulation;
use super::robot::{AHEAD, Robot};

/// Registers by which the tasks are found: who accesses it next has the bug.
const BUTTON: Place = Place::Register(0x4002_0810);
const ENCODER: Place = Place::Register(0x4000_0424);
const PWM: Place = Place::Register(0x4001_003C);
const ALARM: Place = Place::Register(0x4000_0C38);

/// Where, what, how long the motors may be driven after it [ms], and what the next start reports.
type Case = (&'static str, Place, Effect, u64, ResetCause);

/// The guard looks every 10 ms. Control may be missed twice, the others four times, their last sign of
/// life may come just after a look, and a task may be asleep for another 5 ms.
const CASES: &[Case] = &[
    ("a task beside control hangs", BUTTON, Effect::Hang, 50, ResetCause::Watchdog),
    ("encoder capture hangs", ENCODER, Effect::Hang, 33, ResetCause::Watchdog),
    ("PID hangs", PWM, Effect::Hang, 33, ResetCause::Watchdog),
    (
        "the link's interrupt hangs",
        Place::Function("USART3"),
        Effect::Hang,
        50,
        ResetCause::Watchdog,
    ),
    // Control has a timer of its own: this too holds up only what is beside it.
    (
        "the clock's interrupt hangs",
        Place::Function("TIM5"),
        Effect::Hang,
        50,
        ResetCause::Watchdog,
    ),
    // Nobody is left to switch the motors off: the restart does.
    ("the guard itself hangs", Place::Function("SysTick"), Effect::Hang, 45, ResetCause::Watchdog),
    ("a hang with interrupts masked", ALARM, Effect::Hang, 45, ResetCause::Watchdog),
    ("a task beside control panics", BUTTON, Effect::Panic, 5, ResetCause::Panic),
    ("PID panics", PWM, Effect::Panic, 3, ResetCause::Panic),
    ("a hard fault in PID", PWM, Effect::HardFault, 3, ResetCause::Panic),
];

struct Survived {
    powered_ms: f64,
    restart_ms: f64,
    cause: ResetCause,
}

/// Plants a bug at cruise and waits until the board is back.
async fn bear(robot: &mut Robot, case: &Case, number: u32) -> Survived {
    let &(what, place, effect, ..) = case;
    let motion = robot.cruise(&AHEAD, 1500).await;
    let monitor = robot.0.monitor.clone();
    if !monitor.duty().all(|duty| duty > 0.05) {
        panic!("{what}: it does not drive, {:?}", robot.fault().await);
    }
    let (event_us, resets) = (now_us(), monitor.resets_us().len());
    monitor.plant(Bug { place, effect });
    robot.renew(motion, 200).await;
    let resets_us = monitor.resets_us();
    assert_eq!(resets_us.len(), resets + 1, "{what}: one restart");
    robot.meet_again(number).await;
    let identity = robot.0.session.identify().await.unwrap();
    let status = robot.status().await;
    assert_eq!((status.state, status.fault), (State::Idle, None), "{what}: back at rest");
    let ms = |t_us: u64| t_us.saturating_sub(event_us) as f64 * 1e-3;
    Survived {
        powered_ms: monitor.last_powered_us().map_or(0.0, ms),
        restart_ms: ms(resets_us[resets]),
        cause: identity.reset_cause,
    }
}

#[test]
fn what_hangs_or_panics_has_the_motors_off_in_time_and_the_board_back_within_100_ms() {
    let ended = emulation()
        .run(|bench: Bench| async move {
            let mut robot = Robot::meet(bench).await;
            let mut survived = Vec::new();
            for (number, case) in CASES.iter().enumerate() {
                survived.push(bear(&mut robot, case, 2 + number as u32).await);
            }
            survived
        })
        .unwrap();
    assert!(ended.unexpected.is_empty(), "{:#?}", ended.unexpected);
    println!("what happens at cruise           zero duty after   restart after   reported as");
    for ((what, ..), survived) in CASES.iter().zip(&ended.found) {
        println!(
            "{what:<32} {:>12.2} ms {:>12.2} ms   {}",
            survived.powered_ms,
            survived.restart_ms,
            format!("{:?}", survived.cause).to_lowercase(),
        );
    }
    for ((what, .., powered_ms_max, cause), survived) in CASES.iter().zip(&ended.found) {
        assert_eq!(survived.cause, *cause, "{what}");
        assert!(survived.powered_ms <= *powered_ms_max as f64, "{what}: {}", survived.powered_ms);
        assert!(survived.powered_ms <= survived.restart_ms, "{what}: driven after its restart");
        assert!(survived.restart_ms <= 100.0, "{what}: {}", survived.restart_ms);
    }
}
