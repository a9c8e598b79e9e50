//! Slopes.

use beeline_tests::robot::{meters, on_robot};
use shared_proto::{Command, Wheel};

use crate::long_counts::with_counts;

/// Whether a sound robot that drives there and back on a slope, and holds its place after each drive, is stopped.
fn is_stopped(counts_per_rev: f64, slope_rad: f64, payload_kg: f64, speed: (f64, f64)) -> bool {
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
        let report = robot.fault().await;
        if let Some(report) = &report {
            let at =
                |wheel: Wheel| (report.wheels.get(wheel).error_um, report.wheels.get(wheel).duty);
            println!(
                "{counts_per_rev} {slope_rad:.2} {payload_kg} {speed:?}: {:?} {:?} {:?}",
                report.fault,
                at(Wheel::Left),
                at(Wheel::Right)
            );
        }
        report.is_some()
    })
}

#[test]
fn a_sound_robot_holds_its_place_on_a_slope() {
    let (mut drives, mut stopped) = (0, 0);
    for counts_per_rev in [360.0, 900.0, 2797.0] {
        for slope in 1..=7 {
            for payload_kg in [0.0, 4.0] {
                for speed in [(0.2, 0.5), (0.05, 0.1)] {
                    let slope_rad = 0.02 * f64::from(slope);
                    drives += 1;
                    stopped += u32::from(is_stopped(counts_per_rev, slope_rad, payload_kg, speed));
                }
            }
        }
    }
    println!("{stopped} of {drives} are stopped");
}
