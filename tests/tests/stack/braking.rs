//! A motor that loses a lead while its setpoint brakes: the wheel rolls out along with it.

use beeline_tests::robot::{Robot, meters, on_robot};
use shared_proto::{Fault, MotionEnd, State, Status, Wheel};
use sim_target::plant::PlantFault;

use crate::long_counts::with_counts;

const WHEEL: Wheel = Wheel::Right;
const WAY_M: f64 = 0.3;
const RADIUS_M: f64 = 0.036;
const ACCELERATION_MPS2: f64 = 0.8;
/// A wheel further than this from its target has not arrived, by its count \[m\].
const ARRIVED_M: f64 = 0.002;

/// The lead comes off when so much of the ramp is over; what became of the motion, and how far the wheel is from its target
/// \[m\].
async fn cut_at(robot: &mut Robot, cruise_mps: f64, share: f64) -> (Status, f64) {
    let from_m = robot.snapshot().rolled_m.right;
    let ramp_m = cruise_mps * cruise_mps / (2.0 * ACCELERATION_MPS2);
    let cut_m = WAY_M - ramp_m * (1.0 - share).powi(2);
    let id = robot.cruise(&meters(WAY_M, WAY_M, cruise_mps, ACCELERATION_MPS2), 0.1).await;
    while robot.snapshot().rolled_m.right - from_m < cut_m && robot.state().await == State::Driving
    {
        robot.renew(id, 0.005).await;
    }
    robot.testbed.inject(PlantFault::MotorUnplugged(WHEEL));
    robot.renew(id, 2.5).await;
    let error_m = from_m + WAY_M - robot.snapshot().rolled_m.right;
    (robot.session.status().await.expect("status"), error_m)
}

#[test]
fn a_motion_whose_wheel_rolled_out_far_from_its_target_is_not_completed() {
    let names = [Fault::Stall(WHEEL), Fault::FollowingError(WHEEL), Fault::NoResponse(WHEEL)];
    let mut named = 0;
    for counts_per_rev in [360.0, 900.0, 2797.0] {
        for payload_kg in [0.0, 3.0, 8.0] {
            for cruise_mps in [0.15, 0.2, 0.25, 0.3, 0.35] {
                for share in [0.0, 0.2, 0.4, 0.6, 0.8] {
                    let (mut scenario, config) = with_counts(counts_per_rev);
                    scenario.plant.body.payload_kg = payload_kg;
                    // As the robot takes it.
                    scenario.plant.geometry.wheel_radius_m.right = RADIUS_M;
                    scenario.plant.motor.right.coulomb_torque_nm *= 0.7;
                    let (status, error_m) = on_robot(&scenario, async |robot| {
                        robot.session.write_config(&config).await.expect("valid");
                        cut_at(robot, cruise_mps, share).await
                    });
                    let case = (counts_per_rev, payload_kg, cruise_mps, share);
                    match status.fault {
                        Some(report) => {
                            assert!(names.contains(&report.fault), "{case:?}: {}", report.fault);
                            named += 1;
                        }
                        None => {
                            assert_eq!(status.motion_end, Some(MotionEnd::Completed), "{case:?}");
                            let count_m = std::f64::consts::TAU * RADIUS_M / counts_per_rev;
                            // With 900 counts, 3 kg and 0.29 m/s a wheel 18 mm ahead of its target was `completed`.
                            println!("{case:?}: completed {:.1} mm off", error_m * 1e3);
                            assert!(
                                error_m.abs() < ARRIVED_M + count_m,
                                "{case:?}: completed {error_m} m off"
                            );
                        }
                    }
                }
            }
        }
    }
    println!("{named} named");
    assert!(named > 100, "{named}");
}
