//! What a fault says, that it stays latched, and when it may be cleared.

use crate::fault_cases::ROBOT_FAULTS;
use crate::safety::AHEAD;
use beeline_tests::robot::{meters, on_robot};
use shared_proto::{Command, Fault, Refusal, State, Wheel};
use sim_target::plant::PlantFault;
use sim_target::{Scenario, now_us};

#[test]
fn a_fault_says_how_the_wheels_were_just_before_the_motors_went_off() {
    // Raised by the control tick itself: the wheel that is held lags, and is driven harder.
    on_robot(&Scenario::default(), async |robot| {
        let id = robot.cruise(&AHEAD, 2.0).await;
        robot.testbed.inject(PlantFault::EncoderUnplugged(Wheel::Left));
        robot.renew(id, 0.3).await;
        let report = robot.fault().await.expect("named");
        assert_eq!(report.fault, Fault::EncoderDead(Wheel::Left));
        let (left, right) = (report.wheels.left, report.wheels.right);
        assert!((2_000..20_000).contains(&left.error_um), "behind: {report:?}");
        assert!(left.speed_um_s.abs() < 20_000 && left.duty > right.duty, "{report:?}");
        assert!((100_000..140_000).contains(&right.speed_um_s), "{report:?}");
        assert!(right.error_um.abs() < 2_000 && right.duty > 4_000, "{report:?}");
        assert!((11_000..12_500).contains(&report.supply_mv), "{report:?}");
    });
    // Raised by another task, between two ticks.
    on_robot(&Scenario::default(), async |robot| {
        robot.cruise(&AHEAD, 2.0).await;
        robot.tell(Command::EmergencyStop).await;
        robot.listen(0.3).await;
        let report = robot.fault().await.expect("latched");
        let as_at_cruise = |wheel: shared_proto::WheelAtFault| {
            (100_000..140_000).contains(&wheel.speed_um_s) && wheel.duty > 4_000
        };
        assert!(report.wheels.all(as_at_cruise), "and not how they are by now: {report:?}");
    });
}
#[test]
fn a_fault_is_never_cleared_by_itself_and_forbids_arming_and_driving() {
    on_robot(&Scenario::default(), async |robot| {
        let id = robot.cruise(&AHEAD, 1.5).await;
        robot.testbed.inject(PlantFault::EncoderUnplugged(Wheel::Left));
        robot.renew(id, 0.3).await;
        robot.testbed.mend(PlantFault::EncoderUnplugged(Wheel::Left));
        let report = robot.fault().await.expect("latched");
        let off_us = now_us();
        robot.listen(60.0).await;
        robot.reconnect(2).await;
        let still = robot.fault().await.expect("after a minute and a new host");
        assert_eq!(still, report);
        for command in
            [Command::Arm { take: false }, Command::EmergencyStop, Command::Stop, Command::Disarm]
        {
            let answer = robot.ask(command.clone()).await;
            assert_eq!(
                command == Command::Arm { take: false },
                answer.is_err(),
                "{command:?}: {answer:?}"
            );
        }
        assert!(
            matches!(robot.ask(Command::Arm { take: false }).await, Err(Refusal::Faulted(r)) if r.fault == report.fault)
        );
        assert!(matches!(robot.drive(&AHEAD).await, Err(Refusal::Faulted(_))));
        assert_eq!(robot.ask(Command::Renew { motion: id }).await.err(), None);
        for number in [0, report.number + 1, report.number.wrapping_sub(1), u32::MAX] {
            let answer = robot.ask(Command::ClearFault { number }).await;
            assert_eq!(answer, Err(Refusal::NoSuchFault), "number {number}");
        }
        assert_eq!(robot.fault().await.map(|r| r.fault), Some(report.fault));
        assert_eq!(robot.last_powered_us(off_us), None);

        // Sent twice with the right number: the second one is a retry.
        robot.tell(Command::ClearFault { number: report.number }).await;
        robot.tell(Command::ClearFault { number: report.number }).await;
        assert_eq!((robot.state().await, robot.fault().await), (State::Idle, None));
        let id = robot.cruise(&meters(0.1, 0.1, 0.2, 0.5), 0.5).await;
        robot.finish(id).await;
        assert_eq!((robot.state().await, robot.fault().await), (State::Armed, None));
    });
}

#[test]
fn clearing_is_refused_while_the_cause_remains() {
    for &(name, fault, expected) in ROBOT_FAULTS {
        on_robot(&Scenario::default(), async |robot| {
            let id = robot.cruise(&AHEAD, 1.5).await;
            robot.testbed.inject(fault);
            robot.renew(id, 0.3).await;
            let report = robot.fault().await.expect(name);
            let clear = Command::ClearFault { number: report.number };
            assert_eq!(robot.ask(clear.clone()).await, Err(Refusal::CauseRemains), "{name}");
            assert_eq!(robot.fault().await.map(|r| r.fault), Some(expected), "{name}");
            robot.testbed.mend(fault);
            robot.listen(0.01).await;
            assert_eq!(robot.fault().await.map(|r| r.fault), Some(expected), "{name}");
            robot.tell(clear).await;
            assert_eq!(robot.state().await, State::Idle, "{name}");
        });
    }
}

#[test]
fn a_robot_that_must_not_drive_does_not_even_arm() {
    for &(name, fault, expected) in ROBOT_FAULTS {
        on_robot(&Scenario::default(), async |robot| {
            robot.testbed.inject(fault);
            robot.listen(0.05).await;
            match robot.ask(Command::Arm { take: false }).await {
                Err(Refusal::Faulted(report)) => assert_eq!(report.fault, expected, "{name}"),
                other => panic!("{name}: {other:?}"),
            }
            assert_eq!(robot.last_powered_us(0), None, "{name}");
        });
    }
}
