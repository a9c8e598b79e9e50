//! A core that stands still for a while, as when its flash is erased or a debugger holds it: the control
//! timer's ticks of that time are lost.

use beeline_tests::robot::{Robot, meters, on_robot};
use shared_proto::{Fault, State};
use sim_target::Scenario;

/// How long the core stands still \[us\]. Erasing a sector takes 250 ms and more.
const STALLS_US: [u64; 6] = [1_500, 2_000, 2_750, 20_000, 250_000, 1_300_000];

async fn drives(robot: &mut Robot, stall_us: u64) {
    let id = robot.cruise(&meters(0.1, 0.1, 0.2, 0.5), 0.5).await;
    robot.finish(id).await;
    assert_eq!((robot.state().await, robot.fault().await), (State::Armed, None), "{stall_us} us");
}

#[test]
fn after_a_stall_at_rest_the_robot_arms_and_drives() {
    for stall_us in STALLS_US {
        on_robot(&Scenario::default(), async |robot| {
            robot.listen(0.0123).await;
            robot.testbed.stall_cpu(stall_us);
            robot.listen(0.05).await;
            drives(robot, stall_us).await;
            let status = robot.session.status().await.unwrap();
            assert!(
                u64::from(status.ticks_lost).abs_diff(stall_us / 1000) <= 1,
                "{} ticks lost in {stall_us} us",
                status.ticks_lost
            );
        });
    }
}

#[test]
fn a_stall_with_the_motors_on_is_a_fault_that_clears_and_does_not_come_back() {
    for stall_us in STALLS_US {
        on_robot(&Scenario::default(), async |robot| {
            let motion = meters(1.0, 1.0, 0.2, 0.5);
            let id = robot.cruise(&motion, 1.0).await;
            robot.testbed.stall_cpu(stall_us);
            robot.renew(id, 0.1).await;
            let report = robot.fault().await.expect("named");
            assert_eq!(report.fault, Fault::DeadlineMissed, "{stall_us} us");
            robot.tell(shared_proto::Command::ClearFault { number: report.number }).await;
            robot.listen(0.5).await;
            drives(robot, stall_us).await;
        });
    }
}
