//! Motors, gears and drivers that are not perfect: each against what statics or energy expect of it.

use core::f64::consts::TAU;

use shared_proto::{Wheel, WheelPair};

use super::rig::{drive, frictionless, robot};
use crate::plant::{MotorDefectParameters, Plant, PlantFault, PlantParameters};

fn both(defects: MotorDefectParameters) -> PlantParameters {
    PlantParameters { motor_defects: WheelPair::both(defects), ..PlantParameters::default() }
}

#[test]
fn a_defect_of_the_motor_that_never_acts_leaves_the_motion_the_same_to_the_last_bit() {
    let never = MotorDefectParameters { brush_lift_rad_s: 1e4, ..MotorDefectParameters::default() };
    let mut limited = PlantParameters::default();
    limited.bridge.current_limit_a = Some(1e4);
    let mut played = both(never);
    played.gear.left.set_screw_nm = Some(1e3);
    let mut ideal_played = PlantParameters::default();
    ideal_played.gear.left.set_screw_nm = Some(1e3);
    for (ideal, defective) in [
        (PlantParameters::default(), both(never)),
        (PlantParameters::default(), limited),
        (ideal_played, played),
    ] {
        let (mut ideal, mut defective) = (robot(ideal), robot(defective));
        for plant in [&mut ideal, &mut defective] {
            drive(plant, 0.5, 0.3, 2_000_000);
            drive(plant, -0.4, 0.4, 1_000_000);
            drive(plant, 0.0, 0.0, 500_000);
        }
        assert_eq!(ideal.pose(), defective.pose());
        assert_eq!(ideal.counts(), defective.counts());
        assert_eq!(ideal.energy_j().to_bits(), defective.energy_j().to_bits());
        assert_eq!(ideal.bus_v().to_bits(), defective.bus_v().to_bits());
    }
}

/// Whether a wheel turns at this duty, from rest.
fn turns(parameters: &PlantParameters, duty: f64) -> bool {
    let mut plant = robot(parameters.clone());
    drive(&mut plant, duty, duty, 1_500_000);
    plant.wheel_speeds_rad_s().left.abs() > 0.05
}

#[test]
fn stiction_holds_a_wheel_that_would_keep_turning() {
    let sticky =
        both(MotorDefectParameters { stiction_nm: 0.05, ..MotorDefectParameters::default() });
    let perfect = PlantParameters::default();
    assert!(turns(&perfect, 0.06) && !turns(&sticky, 0.06) && turns(&sticky, 0.11));
    // Turning already, both go on alike.
    let speed = |parameters: &PlantParameters| {
        let mut plant = robot(parameters.clone());
        drive(&mut plant, 0.3, 0.3, 500_000);
        drive(&mut plant, 0.08, 0.08, 2_000_000);
        plant.wheel_speeds_rad_s().left
    };
    assert_eq!(speed(&perfect), speed(&sticky));
}

#[test]
fn a_dead_band_takes_its_voltage_and_a_current_limit_its_torque() {
    let mut dead = PlantParameters::default();
    dead.bridge.dead_band_v = 0.6;
    // The same as 5 % less duty, sag aside.
    dead.supply.resistance_ohm = 0.0;
    let perfect = PlantParameters { supply: dead.supply, ..PlantParameters::default() };
    let speed = |parameters: &PlantParameters, duty: f64| {
        let mut plant = robot(parameters.clone());
        drive(&mut plant, duty, duty, 3_000_000);
        plant.wheel_speeds_rad_s().left
    };
    let bus_v = robot(perfect.clone()).bus_v();
    let (a, b) = (speed(&dead, 0.4), speed(&perfect, 0.4 - 0.6 / bus_v));
    assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");

    let mut limited = PlantParameters::default();
    limited.bridge.current_limit_a = Some(0.5);
    let mut plant = robot(limited);
    plant.inject(PlantFault::WheelJammed(Wheel::Left));
    plant.inject(PlantFault::WheelJammed(Wheel::Right));
    drive(&mut plant, 1.0, -1.0, 200_000);
    assert!((plant.currents_a().left - 0.5).abs() < 0.02, "{:?}", plant.currents_a());
    assert!((plant.currents_a().right + 0.5).abs() < 0.02, "{:?}", plant.currents_a());
}

#[test]
fn a_driver_with_a_slew_limit_reaches_its_duty_late_and_begins_anew_when_switched_off() {
    let mut slow = PlantParameters::default();
    slow.bridge.slew_per_s = Some(5.0);
    let mut plant = robot(slow);
    for wheel in [Wheel::Left, Wheel::Right] {
        plant.inject(PlantFault::WheelJammed(wheel));
    }
    // 40 ms of 100 ms, then all of it.
    let current_a = |plant: &mut Plant, t_us: u64| {
        drive(plant, 0.5, -0.5, t_us);
        plant.currents_a().left / plant.bus_v()
    };
    let (begun, whole) = (current_a(&mut plant, 40_000), current_a(&mut plant, 200_000));
    assert!((begun / whole - 0.4).abs() < 0.01, "{begun} {whole}");
    plant.set_enabled(false);
    plant.advance_to(plant.t_us() + 100_000);
    let again = current_a(&mut plant, 40_000);
    assert!((again / begun - 1.0).abs() < 0.01, "{again} {begun}");
}

#[test]
fn a_rotor_comes_to_rest_in_a_slot() {
    let mut parameters = frictionless();
    for motor in [&mut parameters.motor.left, &mut parameters.motor.right] {
        motor.viscous_torque_nms = 0.02;
    }
    let slots = MotorDefectParameters {
        cogging_nm: 0.2,
        cogging_slots: 10.0,
        cogging_phase_rad: 0.2,
        ..MotorDefectParameters::default()
    };
    parameters.motor_defects = WheelPair::both(slots);
    let mut plant = robot(parameters);
    drive(&mut plant, 0.5, 0.5, 1_000_000);
    drive(&mut plant, 0.0, 0.0, 8_000_000);
    let angle_rad = plant.wheel_angles_rad().left;
    let off = ((angle_rad - 0.2) / (TAU / 10.0)).rem_euclid(1.0);
    assert!(off.min(1.0 - off) < 0.02, "{off} of a slot");
}

#[test]
fn a_winding_that_holds_a_wheel_warms_and_its_current_falls_as_copper_has_it() {
    let mut parameters = both(MotorDefectParameters {
        heat_resistance_k_per_w: 30.0,
        heat_capacity_j_per_k: 0.2,
        ..MotorDefectParameters::default()
    });
    parameters.supply.resistance_ohm = 0.0;
    let mut plant = robot(parameters);
    plant.inject(PlantFault::WheelJammed(Wheel::Left));
    plant.inject(PlantFault::WheelJammed(Wheel::Right));
    drive(&mut plant, 0.3, 0.3, 1000);
    let cold_a = plant.currents_a().left;
    drive(&mut plant, 0.3, 0.3, 40_000_000);
    let warm_a = plant.currents_a().left;
    // U I = dT / R_th and I = I_0 / (1 + 0.0039 dT), at rest in temperature.
    let volts = 0.3 * plant.bus_v();
    let warmer_k = 30.0 * volts * warm_a;
    let expected_a = cold_a / (1.0 + 0.0039 * warmer_k);
    assert!((warm_a / expected_a - 1.0).abs() < 0.01, "{warm_a} {expected_a}");
    assert!(warm_a < 0.9 * cold_a, "{warm_a} {cold_a}");
}

#[test]
fn what_a_motor_prefers_is_slower_the_other_way() {
    let one_way = MotorDefectParameters {
        one_way_nm: 0.02,
        brush_lead: 0.02,
        ..MotorDefectParameters::default()
    };
    let speed = |duty: f64| {
        let mut plant = robot(both(one_way));
        drive(&mut plant, duty, duty, 3_000_000);
        plant.wheel_speeds_rad_s().left.abs()
    };
    assert!(speed(0.5) < 0.95 * speed(-0.5), "{} {}", speed(0.5), speed(-0.5));
}
