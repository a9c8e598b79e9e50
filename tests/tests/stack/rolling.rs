//! A robot that still rolls when a motion is commanded, because its driver does not brake.

use beeline_tests::robot::{Robot, meters, on_robot};
use shared_proto::{Command, Config, Drive, MotionEnd, State};
use sim_target::{Scenario, now_us};

use crate::long_counts::with_counts;

/// A robot with other friction and a load, whose driver opens the motors' terminals whenever there is no duty.
pub fn coasting(counts_per_rev: f64, payload_kg: f64, friction: f64) -> (Scenario, Config) {
    let (mut scenario, config) = with_counts(counts_per_rev);
    scenario.plant.bridge.opens_without_duty = true;
    scenario.plant.body.payload_kg = payload_kg;
    let motors = &mut scenario.plant.motor;
    for motor in [&mut motors.left, &mut motors.right] {
        motor.coulomb_torque_nm *= friction;
    }
    (scenario, config)
}

/// An emergency stop at this speed, and at once a motion back, which begins after a time; before it perhaps a configuration.
/// How far the left wheel rolled back from where it turned round \[m\].
async fn back_after_a_stop(
    robot: &mut Robot,
    cruise_mps: f64,
    begin_s: Option<f64>,
    config: Option<&Config>,
) -> f64 {
    robot.cruise(&meters(2.0, 2.0, cruise_mps, 0.3), 2.0).await;
    robot.tell(Command::EmergencyStop).await;
    let report = robot.fault().await.expect("the emergency stop");
    robot.tell(Command::ClearFault { number: report.number }).await;
    let from_m = robot.snapshot().rolled_m.left;
    robot.listen(0.05).await;
    let rolled_m = robot.snapshot().rolled_m.left - from_m;
    assert!(rolled_m > 0.6 * 0.05 * cruise_mps, "it rolls: {rolled_m} m");

    if let Some(config) = config {
        robot.session.write_config(config).await.expect("valid");
    }
    robot.tell(Command::Arm { take: false }).await;
    let motion = robot.session.new_motion();
    let start_us = begin_s.map(|s| now_us() + (s * 1e6) as u64);
    let back = meters(-0.2, -0.2, 0.1, 0.2).drive_now(motion);
    robot.tell(Command::Drive(Drive { start_us, ..back })).await;
    let mut farthest_m = f64::MIN;
    while matches!(robot.state().await, State::Driving | State::Stopping) {
        robot.renew(motion, 0.01).await;
        farthest_m = farthest_m.max(robot.snapshot().rolled_m.left);
    }
    farthest_m - robot.snapshot().rolled_m.left
}

#[test]
fn a_robot_that_coasts_is_waited_for_and_then_drives_the_other_way_as_far_as_told() {
    for counts_per_rev in [200.0, 900.0, 2797.0] {
        for (payload_kg, friction) in [(0.0, 1.0), (5.0, 0.5), (10.0, 0.5)] {
            for (cruise_mps, begin_s) in
                [(0.12, None), (0.3, None), (0.12, Some(0.1)), (0.3, Some(0.3)), (0.3, Some(1.5))]
            {
                let (scenario, config) = coasting(counts_per_rev, payload_kg, friction);
                // A configuration that is written while it rolls does not hide that: it was `encoder_reversed`.
                for again in [None, Some(&config)] {
                    on_robot(&scenario, async |robot| {
                        robot.session.write_config(&config).await.expect("valid");
                        let back_m = back_after_a_stop(robot, cruise_mps, begin_s, again).await;
                        let case = (
                            counts_per_rev,
                            payload_kg,
                            friction,
                            cruise_mps,
                            begin_s,
                            again.is_some(),
                        );
                        let status = robot.session.status().await.expect("status");
                        let fault = status.fault.map(|report| report.fault);
                        println!("{case:?}: {:.1} mm back", back_m * 1e3);
                        // It was `encoder_reversed`, `encoders_exchanged` with long counts, and `following_error`: the
                        // motion was planned from where the wheels were when it was commanded.
                        assert_eq!(fault, None, "{case:?}");
                        assert_eq!(status.motion_end, Some(MotionEnd::Completed), "{case:?}");
                        // The check itself is not of the motion: up to three counts, and what it rolls on.
                        assert!((0.197..0.205).contains(&back_m), "{case:?}: {back_m} m");
                    });
                }
            }
        }
    }
}
