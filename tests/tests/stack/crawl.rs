//! Sound robots with more friction than is configured, in slow motions.

use beeline_tests::robot::{meters, on_robot};
use shared_proto::MotionEnd;

use crate::long_counts::with_counts;

#[test]
fn a_sound_robot_with_more_friction_crawls_where_it_is_told() {
    for counts_per_rev in [360.0, 506.0, 900.0, 2797.0] {
        for friction in [1.5, 1.75, 2.06] {
            for supply_v in [10.8, 12.0, 15.6] {
                for (cruise_mps, acceleration_mps2) in
                    [(0.005, 0.005), (0.00912, 0.00644), (0.015, 0.02)]
                {
                    let (mut scenario, config) = with_counts(counts_per_rev);
                    scenario.plant.supply.open_circuit_v = supply_v;
                    scenario.plant.motor.left.coulomb_torque_nm *= friction;
                    scenario.plant.motor.right.coulomb_torque_nm *= 1.5;
                    on_robot(&scenario, async |robot| {
                        robot.session.write_config(&config).await.expect("valid");
                        let case = (counts_per_rev, friction, supply_v, cruise_mps);
                        let motion = meters(-0.02, -0.02, cruise_mps, acceleration_mps2);
                        let id = robot.cruise(&motion, 0.1).await;
                        robot.finish(id).await;
                        let status = robot.session.status().await.expect("status");
                        // The check had rolled the wheel ahead, the loop held it back until its setpoint came; and 2 mm later, with a
                        // duty that this friction takes, it was `no_response`.
                        assert_eq!(status.fault.map(|report| report.fault), None, "{case:?}");
                        assert_eq!(status.motion_end, Some(MotionEnd::Completed), "{case:?}");
                    });
                }
            }
        }
    }
}
