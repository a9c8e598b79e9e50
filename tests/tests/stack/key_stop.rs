//! Stops of a robot with a key: from a fresh connection, under flood, after a restart.

use beeline_tests::robot::{on_robot_with, own_secret};
use futures_lite::future;
use shared_proto::{Command, Encoder, Hello, Request, State};
use sim_target::{Scenario, now_us, sleep_until_us};

use crate::key::{ByHand, KEY, OTHER, ahead, with_key};

/// What fills the line while somebody wants to stop the robot.
#[derive(Clone, Copy, Debug)]
enum Flood {
    Hellos,
    Forgeries,
    Garbage,
    Driver,
}

#[test]
fn a_holder_of_the_key_stops_the_robot_within_100_ms_from_a_fresh_connection_under_any_flood() {
    for flood in [Flood::Hellos, Flood::Forgeries, Flood::Garbage, Flood::Driver] {
        on_robot_with(&Scenario::default(), with_key(), async |robot| {
            let id = robot.cruise(&ahead(), 1.0).await;
            let wire = robot.wire.clone();
            let mut driver = ByHand::open(&wire, 8).await;
            let mut other = sim_link::session(&robot.wire, 9, "sim");
            other.use_key(KEY, own_secret(9));
            let mut encoder = Encoder::new();
            let mut number = 100;
            let flooding = async {
                loop {
                    while wire.has_room() {
                        number += 1;
                        wire.write_now(&match flood {
                            Flood::Hellos => encoder.hello(Hello::of_this_build(number)).to_vec(),
                            Flood::Forgeries => {
                                let command = Command::Renew { motion: id };
                                let request =
                                    Request { session: 8, id: number, until_ms: 0, command };
                                encoder
                                    .sealed_message(&request, Some((&OTHER, u64::from(number))))
                                    .to_vec()
                            }
                            Flood::Garbage => {
                                (0..100).map(|i| (number * 31 + i * 7) as u8).collect()
                            }
                            Flood::Driver => driver.frame(Command::Status),
                        });
                    }
                    sleep_until_us(now_us() + 200).await;
                }
            };
            let stop = async {
                // The motion is renewed beside the flood.
                for _ in 0..6 {
                    robot.session.post(Command::Renew { motion: id }).await.expect("sent");
                    sleep_until_us(now_us() + 50_000).await;
                }
                assert!(robot.snapshot().is_powered(), "{flood:?}: it still drives");
                let event_us = now_us();
                let _ = other.emergency_stop().await;
                let off_us = robot.last_powered_us(event_us).unwrap_or(event_us) - event_us;
                println!("{flood:?}: off after {off_us} us");
                assert!(off_us <= 100_000, "{flood:?}: {off_us}");
                assert!(!robot.snapshot().is_powered());
            };
            future::or(stop, flooding).await;
        });
    }
}

#[test]
fn after_a_restart_a_stop_from_an_open_session_and_from_a_fresh_one_takes_under_100_ms() {
    on_robot_with(&Scenario::default(), with_key(), async |robot| {
        for fresh in [false, true] {
            robot.testbed.restart_controller();
            sleep_until_us(now_us() + 60_000).await;
            let mut host = sim_link::session(&robot.wire, 30, "sim");
            host.use_key(KEY, own_secret(30));
            let session = if fresh { &mut host } else { &mut robot.session };
            let event_us = now_us();
            session.emergency_stop().await.expect("it stops");
            let took_us = now_us() - event_us;
            println!("fresh {fresh}: {took_us} us");
            assert!(took_us < 100_000, "fresh {fresh}: {took_us}");
        }
        drop(robot.another_host(31).await);
        assert_eq!(robot.state().await, State::Faulted);
    });
}
