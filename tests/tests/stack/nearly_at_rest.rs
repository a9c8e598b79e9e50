//! Velocities so small that a count hardly changes: of a stick that trembles, or of the inner wheel of a turn.

use beeline_tests::robot::on_robot;
use shared_proto::{Command, Config, Velocity, Wheel};
use sim_target::plant::PlantFault;

use crate::long_counts::with_counts;
use crate::velocity::{drive, velocity};

/// A stick that trembles by so much \[m/s\], to and fro in 0.2 s.
fn trembles(by_mps: f64) -> impl Fn(f64) -> Velocity {
    move |t| velocity(if t.rem_euclid(0.2) < 0.1 { by_mps } else { -by_mps }, 0.0)
}

/// A turn about the left wheel, which goes on at this speed \[m/s\].
fn turns_about_left(wheel_mps: f64) -> impl Fn(f64) -> Velocity {
    const OUTER_MPS: f64 = 0.1;
    let track_width_m = Config::default().geometry.track_width_m;
    let turn_rad_s = (OUTER_MPS - wheel_mps) / track_width_m;
    move |_| velocity(0.5 * (OUTER_MPS + wheel_mps), turn_rad_s)
}

/// How far the left wheel rolls within so long of its encoder's end \[m\].
fn rolled_m(counts_per_rev: f64, wanted: &dyn Fn(f64) -> Velocity, within_s: f64) -> f64 {
    let (scenario, config) = with_counts(counts_per_rev);
    on_robot(&scenario, async |robot| {
        robot.session.write_config(&config).await.expect("valid");
        robot.tell(Command::Arm { take: false }).await;
        drive(robot, 0.05, 2.0, |_| velocity(0.05, 0.0)).await;
        drive(robot, 0.05, 1.0, wanted).await;
        let before = robot.snapshot();
        robot.testbed.inject(PlantFault::EncoderUnplugged(Wheel::Left));
        drive(robot, 0.05, within_s, wanted).await;
        (robot.snapshot().rolled_m.left - before.rolled_m.left).abs()
    })
}

#[test]
fn an_encoder_that_dies_while_a_stick_trembles_does_not_let_its_wheel_run() {
    for counts_per_rev in [200.0, 360.0, 900.0, 2797.0] {
        for by_mps in [0.0005, 0.001, 0.002] {
            let rolled_m = rolled_m(counts_per_rev, &trembles(by_mps), 30.0);
            println!("{counts_per_rev} counts, {by_mps} m/s: {:.0} mm", rolled_m * 1e3);
            // The integral summed an error of less than a count up to full duty, and nothing looked: 10 m in 30 s.
            assert!(rolled_m < 0.4, "{counts_per_rev} counts, {by_mps} m/s: {rolled_m} m");
        }
    }
}

#[test]
fn an_encoder_that_dies_on_the_inner_wheel_of_a_turn_does_not_let_it_run() {
    for counts_per_rev in [360.0, 900.0, 2797.0] {
        for wheel_mps in [0.0, 1e-5, 1e-4, 3e-4, 1e-3] {
            let rolled_m = rolled_m(counts_per_rev, &turns_about_left(wheel_mps), 30.0);
            println!("{counts_per_rev} counts, {wheel_mps} m/s: {:.0} mm", rolled_m * 1e3);
            // 1.5 m at 0.01 mm/s with 900 counts.
            assert!(rolled_m < 0.2, "{counts_per_rev} counts, {wheel_mps} m/s: {rolled_m} m");
        }
    }
}

#[test]
fn a_sound_robot_with_more_friction_and_a_low_battery_obeys_a_stick_that_trembles() {
    for counts_per_rev in [360.0, 900.0, 2797.0, 20_000.0] {
        for (supply_v, payload_kg) in [(12.0, 0.0), (9.6, 0.0), (10.5, 8.0)] {
            for by_mps in [0.001, 0.005] {
                let (mut scenario, config) = with_counts(counts_per_rev);
                scenario.plant.supply.open_circuit_v = supply_v;
                scenario.plant.body.payload_kg = payload_kg;
                let motors = &mut scenario.plant.motor;
                for motor in [&mut motors.left, &mut motors.right] {
                    motor.coulomb_torque_nm *= 2.0;
                }
                on_robot(&scenario, async |robot| {
                    robot.session.write_config(&config).await.expect("valid");
                    robot.tell(Command::Arm { take: false }).await;
                    drive(robot, 0.05, 2.0, |_| velocity(0.05, 0.0)).await;
                    drive(robot, 0.05, 20.0, trembles(by_mps)).await;
                    let fault = robot.fault().await.map(|report| report.fault);
                    let case = (counts_per_rev, supply_v, payload_kg, by_mps);
                    assert_eq!(fault, None, "{case:?}");
                });
            }
        }
    }
}
