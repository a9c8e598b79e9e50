//! A key is set, changed and cleared; and what makes each start of a robot differ.

use beeline_tests::robot::{on_robot, on_robot_with, own_secret};
use host_link::Error;
use shared_proto::{Command, Decoder, Encoder, Hello, Refusal, State};
use sim_target::{Options, Scenario, now_us, sleep_until_us};

use crate::key::{ByHand, KEY, OTHER, hear, with_key};

#[test]
fn a_key_is_set_changed_and_cleared_only_disarmed_and_by_who_holds_it_and_stays_after_a_restart() {
    on_robot(&Scenario::default(), async |robot| {
        robot.tell(Command::Arm { take: false }).await;
        let armed = robot.ask(Command::SetKey { key: Some(KEY) }).await;
        assert_eq!(armed, Err(Refusal::State(State::Armed)));
        robot.tell(Command::Disarm).await;
        robot.testbed.write_protect_flash(true);
        assert_eq!(robot.ask(Command::SetKey { key: Some(KEY) }).await, Err(Refusal::Store));
        robot.testbed.write_protect_flash(false);
        let mut before = robot.another_host(2).await;
        robot.session.set_key(Some(KEY), own_secret(2)).await.expect("there was none");
        robot.tell(Command::Arm { take: false }).await;
        robot.tell(Command::Disarm).await;
        assert!(before.status().await.is_err(), "a session of before has ended");
        for number in 3..6 {
            robot.testbed.restart_controller();
            sleep_until_us(now_us() + 100_000).await;
            let mut stranger = sim_link::session(&robot.wire, number, "sim");
            assert!(matches!(stranger.open().await, Err(Error::KeyNeeded { .. })));
            robot.session = sim_link::session(&robot.wire, number + 10, "sim");
            robot.session.use_key(KEY, own_secret(number));
            robot.session.open().await.expect("it kept the key");
        }
        robot.session.set_key(Some(OTHER), own_secret(20)).await.expect("it holds the key");
        let mut old = sim_link::session(&robot.wire, 40, "sim");
        old.use_key(KEY, own_secret(40));
        assert!(matches!(old.open().await, Err(Error::WrongKey { .. })));
        let config = format!("{:?}", robot.session.read_config().await.expect("it answers"));
        assert!(!config.contains("test"), "{config}");
        robot.session.set_key(None, own_secret(21)).await.expect("it holds the key");
        drop(robot.another_host(50).await);
        robot.tell(Command::Arm { take: false }).await;
    });
}

#[test]
fn no_challenge_comes_twice_whatever_restarts_and_a_robot_that_cannot_count_lets_nobody_in() {
    on_robot_with(&Scenario::default(), Options { random: None, ..with_key() }, async |robot| {
        let mut challenges = Vec::new();
        let mut decoder = Decoder::new();
        for number in 100..160 {
            if number % 3 == 0 {
                robot.testbed.restart_controller();
                sleep_until_us(now_us() + 60_000).await;
            }
            let hello = Encoder::new().hello(Hello::of_this_build(number));
            robot.wire.write_now(&hello);
            let challenge = hear(&robot.wire, &mut decoder, |frame| frame.challenge()).await;
            challenges.push(challenge.expect("a challenge"));
            ByHand::open(&robot.wire, number).await;
        }
        let count = challenges.len();
        challenges.sort_unstable();
        challenges.dedup();
        assert_eq!(challenges.len(), count);
        robot.testbed.write_protect_flash(true);
        robot.testbed.restart_controller();
        sleep_until_us(now_us() + 60_000).await;
        assert!(matches!(
            robot.session.open().await,
            Err(Error::NotARobot { .. } | Error::NoAnswer { .. })
        ));
    });
}
