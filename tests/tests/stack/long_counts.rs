//! Encoders with few counts a turn: how far a wheel rolls after its encoder died in a slow drive.

use beeline_tests::robot::{Robot, meters, on_robot};
use shared_proto::{Config, Fault, Wheel};
use sim_target::Scenario;
use sim_target::plant::PlantFault;

/// Counts a turn, and how far a wheel may roll in the drive \[mm\] (docs/safety.md).
const ENCODERS: [(f64, f64); 6] =
    [(900.0, 9.0), (360.0, 13.0), (200.0, 26.0), (100.0, 36.0), (64.0, 48.0), (48.0, 58.0)];
/// From the command until the encoder dies \[s\]: in the check, the ramp, and the cruise, where a count of 4.7 mm takes 0.47 s.
fn into_s() -> impl Iterator<Item = f64> {
    (2..12).map(|tenth| 0.1 * f64::from(tenth)).chain([3.0, 3.1, 3.2, 3.3, 3.4])
}

pub fn with_counts(counts_per_rev: f64) -> (Scenario, Config) {
    let (mut scenario, mut config) = (Scenario::default(), Config::default());
    scenario.plant.encoder.left.counts_per_rev = counts_per_rev;
    scenario.plant.encoder.right.counts_per_rev = counts_per_rev;
    config.encoder.left.counts_per_rev = counts_per_rev;
    config.encoder.right.counts_per_rev = counts_per_rev;
    (scenario, config)
}

/// How far the left wheel rolled until it stood \[mm\], and the fault.
async fn rolled_mm(robot: &mut Robot, into_s: f64) -> (f64, Fault) {
    let id = robot.cruise(&meters(1.0, 1.0, 0.01, 0.02), into_s).await;
    let before = robot.snapshot();
    robot.testbed.inject(PlantFault::EncoderUnplugged(Wheel::Left));
    robot.renew(id, 3.0).await;
    let rolled_m = robot.snapshot().rolled_m.left - before.rolled_m.left;
    (rolled_m * 1000.0, robot.fault().await.expect("named").fault)
}

#[test]
fn a_dead_encoder_with_few_counts_does_not_let_its_wheel_run() {
    for (counts_per_rev, most_mm) in ENCODERS {
        let (scenario, config) = with_counts(counts_per_rev);
        let mut all_mm = Vec::new();
        for into_s in into_s() {
            let (mm, fault) = on_robot(&scenario, async |robot| {
                robot.session.write_config(&config).await.expect("valid");
                rolled_mm(robot, into_s).await
            });
            let names = [Fault::NoResponse(Wheel::Left), Fault::EncoderDead(Wheel::Left)];
            assert!(names.contains(&fault), "{counts_per_rev} counts: {fault}");
            all_mm.push(mm);
        }
        println!("{counts_per_rev} counts a turn: {all_mm:.1?} mm");
        assert!(all_mm.iter().all(|mm| *mm < most_mm), "{counts_per_rev} counts: {all_mm:?} mm");
    }
}

#[test]
fn a_sound_robot_with_twice_the_friction_passes_its_check_with_any_encoder() {
    let mut refused = Vec::new();
    for counts_per_rev in
        [48.0, 64.0, 69.0, 100.0, 130.0, 187.0, 220.0, 260.0, 300.0, 360.0, 450.0, 900.0]
    {
        for (friction, payload_kg, supply_v) in [
            (1.0, 0.0, 12.0),
            (1.5, 0.0, 12.0),
            (2.0, 0.0, 12.0),
            (2.0, 4.0, 12.0),
            (2.0, 0.0, 17.0),
            (2.0, 3.0, 17.0),
            (2.0, 4.0, 17.5),
            (2.0, 4.0, 9.6),
            (2.5, 0.0, 12.0),
        ] {
            // With 4 kg and a low supply friction holds it against 0.1 of duty more than is configured.
            if counts_per_rev < 100.0 && (payload_kg, supply_v) == (4.0, 9.6) {
                continue;
            }
            let (mut scenario, config) = with_counts(counts_per_rev);
            scenario.plant.body.payload_kg = payload_kg;
            scenario.plant.supply.open_circuit_v = supply_v;
            scenario.plant.motor.left.coulomb_torque_nm *= friction;
            scenario.plant.motor.right.coulomb_torque_nm *= friction;
            for into in 0..4 {
                let fault = on_robot(&scenario, async |robot| {
                    robot.session.write_config(&config).await.expect("valid");
                    robot.listen(0.1).await;
                    // The wheels stand somewhere else between two counts.
                    let short_m = 0.02 + 0.3e-3 * f64::from(into);
                    let id = robot.cruise(&meters(short_m, short_m, 0.05, 0.2), 0.1).await;
                    robot.finish(id).await;
                    robot.fault().await
                });
                if let Some(report) = fault {
                    refused.push((
                        counts_per_rev,
                        friction,
                        payload_kg,
                        supply_v,
                        into,
                        report.fault,
                    ));
                }
            }
        }
    }
    for r in &refused {
        println!("REF {r:?}");
    }
    assert!(refused.is_empty(), "{refused:#?}");
}
