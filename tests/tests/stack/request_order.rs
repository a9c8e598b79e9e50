//! What a line holds back or repeats is not obeyed once its host has gone on.

use beeline_tests::robot::{meters, on_robot};
use shared_proto::{Command, Encoder, MotionId, Name, Request, State};
use sim_target::{Scenario, now_us};

#[test]
fn a_copy_of_an_earlier_request_changes_nothing_once_a_later_one_has_come() {
    on_robot(&Scenario::default(), async |robot| {
        let first = robot.session.read_config().await.expect("it answers");
        let mut second = first.clone();
        second.name = Name::new("the second").expect("a name");
        let mut encoder = Encoder::new();
        let mut frame = |id, command| {
            let until_ms = now_us() / 1000 + 1000;
            encoder.message(&Request { session: 1, id, until_ms, command }).to_vec()
        };
        let write_first = frame(101, Command::WriteConfig(first));
        let write_second = frame(102, Command::WriteConfig(second.clone()));
        for bytes in [&write_first, &write_second, &write_second, &write_first] {
            robot.wire.write_now(bytes);
            robot.listen(0.02).await;
        }
        let config = robot.session.read_config().await.expect("it answers");
        assert_eq!(config, second, "a copy of the first came last");

        let arm = frame(103, Command::Arm { take: false });
        let drive = Command::Drive(meters(1.0, 1.0, 0.2, 1.0).drive_now(MotionId(9)));
        let drive = frame(104, drive);
        let disarm = frame(105, Command::Disarm);
        for (bytes, state) in [
            (&arm, State::Armed),
            (&arm, State::Armed),
            (&disarm, State::Idle),
            (&arm, State::Idle),
            (&drive, State::Idle),
            // A stop is one whenever it comes.
            (&disarm, State::Idle),
        ] {
            robot.wire.write_now(bytes);
            robot.listen(0.02).await;
            assert_eq!(robot.state().await, state);
        }
        // Another host's numbers are its own.
        drop(robot.another_host(2).await);
        robot.tell(Command::Arm { take: false }).await;
    });
}
