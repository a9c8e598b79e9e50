//! Sound robots on slopes.

use beeline_tests::robot::{meters, on_robot};
use shared_proto::{Command, Fault};

use crate::long_counts::with_counts;

/// What stops a sound robot that drives there and back on a slope, and holds its place after each drive.
fn stopped(
    counts_per_rev: f64,
    slope_rad: f64,
    payload_kg: f64,
    speed: (f64, f64),
) -> Option<Fault> {
    let (mut scenario, mut config) = with_counts(counts_per_rev);
    scenario.plant.floor.slope_rad = slope_rad;
    scenario.plant.body.payload_kg = payload_kg;
    config.limits.hold_s = 60.0;
    on_robot(&scenario, async |robot| {
        robot.session.write_config(&config).await.expect("valid");
        robot.tell(Command::Arm { take: false }).await;
        for way_m in [0.15, -0.15, -0.1, 0.1] {
            let motion = meters(way_m, way_m, speed.0, speed.1);
            let Ok(id) = robot.drive(&motion).await else { break };
            robot.renew(id, 4.0).await;
            robot.finish(id).await;
            robot.listen(2.0).await;
        }
        robot.fault().await.map(|report| report.fault)
    })
}

#[test]
fn a_sound_robot_holds_its_place_on_a_slope() {
    for counts_per_rev in [360.0, 900.0, 2797.0] {
        for slope_rad in [0.02, 0.04, 0.06, 0.08, 0.10] {
            for payload_kg in [0.0, 4.0] {
                for speed in [(0.2, 0.5), (0.05, 0.1)] {
                    // With 4 kg it was a stall from 0.10 rad on: the duty that holds it passed for a push in vain.
                    let stopped = stopped(counts_per_rev, slope_rad, payload_kg, speed);
                    let case = (counts_per_rev, slope_rad, payload_kg, speed);
                    assert_eq!(stopped, None, "{case:?}");
                }
            }
        }
    }
}
