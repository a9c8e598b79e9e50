use shared_proto::{Wheel, WheelPair};

use super::rig::{drive, frictionless, robot};
use crate::plant::{PlantFault, PlantParameters};

#[test]
fn without_friction_top_speed_is_where_back_emf_meets_the_bus() {
    let parameters = frictionless();
    let constant = parameters.motor.left.wheel_torque_constant_nm_per_a();
    let mut plant = robot(parameters);
    drive(&mut plant, 1.0, 1.0, 10_000_000);
    let expected_rad_s = plant.bus_v() / constant;
    let spin_rad_s = plant.wheel_speeds_rad_s().left;
    assert!((spin_rad_s / expected_rad_s - 1.0).abs() < 1e-9, "{spin_rad_s}, {expected_rad_s}");
    let turns_per_s = spin_rad_s / core::f64::consts::TAU;
    assert!(
        (2.2..2.3).contains(&turns_per_s),
        "the standard gear motor's 2.2 turns/s: {turns_per_s}"
    );
}

#[test]
fn a_stalled_motor_draws_bus_over_resistance_and_gives_the_standard_stall_torque() {
    let parameters = PlantParameters::default();
    let motor = parameters.motor.left;
    let mut plant = robot(parameters);
    plant.inject(PlantFault::WheelJammed(Wheel::Left));
    plant.inject(PlantFault::WheelJammed(Wheel::Right));
    drive(&mut plant, 1.0, 0.0, 100_000);
    let current_a = plant.currents_a().left;
    assert!((current_a - plant.bus_v() / motor.resistance_ohm).abs() < 1e-12);
    let torque_nm = current_a * motor.wheel_torque_constant_nm_per_a();
    assert!((1.4..1.55).contains(&torque_nm), "{torque_nm}");
}

#[test]
fn the_bus_sags_by_what_both_motors_draw() {
    let parameters = PlantParameters::default();
    let supply = parameters.supply;
    let mut plant = robot(parameters);
    plant.inject(PlantFault::WheelJammed(Wheel::Left));
    plant.inject(PlantFault::WheelJammed(Wheel::Right));
    drive(&mut plant, 0.8, -0.5, 100_000);
    let currents = plant.currents_a();
    let drawn_a = 0.8 * currents.left - 0.5 * currents.right + supply.standby_current_a;
    let expected_v = supply.open_circuit_v - supply.resistance_ohm * drawn_a;
    assert!((plant.bus_v() - expected_v).abs() < 1e-12, "{}, {expected_v}", plant.bus_v());
    assert!(drawn_a > 1.5);
}

#[test]
fn on_ice_a_wheel_spins_up_as_the_motor_equation_says() {
    let mut parameters = frictionless();
    parameters.floor.friction = 0.0;
    parameters.supply.resistance_ohm = 0.0;
    let motor = parameters.motor.left;
    let inertia = parameters.geometry.wheel_inertia_kgm2
        + motor.rotor_inertia_kgm2 * motor.gear_ratio.powi(2);
    let k = motor.wheel_torque_constant_nm_per_a();
    let tau_s = inertia * motor.resistance_ohm / (k * k);
    let final_rad_s = 0.5 * parameters.supply.open_circuit_v / k;
    let mut plant = robot(parameters);
    plant.set_enabled(true);
    plant.set_duty(WheelPair::both(0.5));
    for ms in 1..=40_u64 {
        plant.advance_to(ms * 1000);
        let expected_rad_s = final_rad_s * (1.0 - (-(ms as f64) * 1e-3 / tau_s).exp());
        let spin_rad_s = plant.wheel_speeds_rad_s().right;
        // The trapezoidal rule at h/tau = 1/15: off by less than (h/tau)^2 / 12 / e.
        assert!((spin_rad_s - expected_rad_s).abs() < 2e-4 * final_rad_s, "{ms} ms: {spin_rad_s}");
    }
    assert_eq!(plant.pose().x_m, 0.0, "ice");
}

#[test]
fn open_terminals_carry_no_current() {
    let mut plant = robot(PlantParameters::default());
    drive(&mut plant, 0.6, 0.6, 1_000_000);
    plant.set_enabled(false);
    plant.advance_to(1_010_000);
    assert_eq!(plant.currents_a(), WheelPair::both(0.0));
    assert!(plant.wheel_speeds_rad_s().left > 1.0, "and it still rolls");
}

#[test]
fn shorted_motors_brake_harder_than_open_ones() {
    let mut shorted = robot(PlantParameters::default());
    drive(&mut shorted, 0.6, 0.6, 1_000_000);
    let mut open = shorted.clone();
    open.set_enabled(false);
    open.advance_to(1_100_000);
    drive(&mut shorted, 0.0, 0.0, 10_000);
    assert!(shorted.currents_a().left < -0.1, "it brakes by its own current");
    drive(&mut shorted, 0.0, 0.0, 90_000);
    assert!(shorted.twist().forward_mps < 0.5 * open.twist().forward_mps);
}

/// Duty against motion, duty = ks + kv v + ka a, from runs at constant duty and on a duty ramp.
#[test]
fn the_standard_robots_feedforward_is_what_its_parameters_say() {
    let parameters = PlantParameters::default();
    let (motor, radius_m) = (parameters.motor.left, parameters.geometry.wheel_radius_m.left);
    let speed_at = |duty: f64| {
        let mut plant = robot(parameters.clone());
        drive(&mut plant, duty, duty, 3_000_000);
        plant.wheel_speeds_rad_s().left * radius_m
    };
    let kv = 0.15 / (speed_at(0.3) - speed_at(0.15));
    let ks = 0.15 - kv * speed_at(0.15);

    let mut plant = robot(parameters.clone());
    drive(&mut plant, 0.1, 0.1, 2_000_000);
    let mut marks_mps = Vec::new();
    for ms in 0..3000_u64 {
        let duty = 0.1 + 1e-4 * ms as f64;
        drive(&mut plant, duty, duty, 1000);
        if ms == 1999 || ms == 2999 {
            marks_mps.push(plant.wheel_speeds_rad_s().left * radius_m);
        }
    }
    let acceleration_mps2 = marks_mps[1] - marks_mps[0];
    // Each duty was held for a millisecond: its mean lies half a step earlier.
    let ka = (0.39995 - ks - kv * marks_mps[1]) / acceleration_mps2;

    // The same from the parameters: friction, back-EMF and inertia, each through one motor.
    let k = motor.wheel_torque_constant_nm_per_a();
    let duty_per_nm = motor.resistance_ohm / (k * plant.bus_v());
    let load_n = plant.loads().driven_n.left;
    let caster_n = plant.loads().caster_n * parameters.caster.rolling_resistance;
    let friction_nm = motor.coulomb_torque_nm
        + radius_m * (parameters.tyre.rolling_resistance * load_n + 0.5 * caster_n);
    let inertia = parameters.geometry.wheel_inertia_kgm2
        + motor.rotor_inertia_kgm2 * motor.gear_ratio.powi(2)
        + 0.5 * parameters.body.mass_kg * radius_m * radius_m;
    let expected_ks = friction_nm * duty_per_nm;
    let expected_kv = (k / plant.bus_v() + motor.viscous_torque_nms * duty_per_nm) / radius_m;
    let expected_ka = inertia * duty_per_nm / radius_m;
    println!("ks {ks:.4} kv {kv:.4} s/m ka {ka:.4} s^2/m");
    // Sag bends the line a little, and rolling resistance fades at a crawl.
    assert!((ks / expected_ks - 1.0).abs() < 0.02, "ks {ks}, {expected_ks}");
    assert!((kv / expected_kv - 1.0).abs() < 0.005, "kv {kv}, {expected_kv}");
    // The ramp lags a few per cent of duty, of which kv and ks leave their own error.
    assert!((ka / expected_ka - 1.0).abs() < 0.05, "ka {ka}, {expected_ka}");
}

#[test]
fn disabled_a_driver_that_shorts_brakes_and_another_one_lets_the_wheel_roll() {
    let speed_after_50_ms = |shorts_when_off| {
        let mut parameters = PlantParameters::default();
        parameters.bridge.shorts_when_off = shorts_when_off;
        let mut plant = robot(parameters);
        drive(&mut plant, 0.5, 0.5, 2_000_000);
        let before = plant.wheel_speeds_rad_s().left;
        plant.set_enabled(false);
        plant.advance_to(plant.t_us() + 50_000);
        plant.wheel_speeds_rad_s().left / before
    };
    let (shorted, open) = (speed_after_50_ms(true), speed_after_50_ms(false));
    assert!(shorted < 0.6 && open > 0.8, "{shorted} {open}");
}

#[test]
fn a_driver_with_a_fault_of_its_own_shorts_nothing() {
    let current_a = |fault: bool| {
        let mut parameters = PlantParameters::default();
        parameters.bridge.shorts_when_off = true;
        let mut plant = robot(parameters);
        drive(&mut plant, 0.5, 0.5, 1_000_000);
        plant.set_enabled(false);
        if fault {
            plant.inject(PlantFault::DriverFault);
        }
        plant.advance_to(plant.t_us() + 1_000);
        plant.currents_a().left
    };
    assert!(current_a(false) < -0.05, "{}", current_a(false));
    assert_eq!(current_a(true), 0.0);
}
