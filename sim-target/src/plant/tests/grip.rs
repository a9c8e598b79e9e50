use super::rig::{drive, frictionless, robot};
use crate::plant::PlantParameters;

#[test]
fn on_a_slippery_floor_the_wheels_spin_and_grip_alone_moves_the_robot() {
    let mut parameters = frictionless();
    parameters.floor.friction = 0.01;
    let mass_kg = parameters.body.mass_kg;
    let mut plant = robot(parameters);
    drive(&mut plant, 1.0, 1.0, 1_000_000);
    let load_n = plant.loads().driven_n;
    let expected_mps = 0.01 * (load_n.left + load_n.right) / mass_kg;
    let speed_mps = plant.twist().forward_mps;
    // Until the tread slides takes a few milliseconds of the second.
    assert!((speed_mps / expected_mps - 1.0).abs() < 0.01, "{speed_mps}, {expected_mps}");
    let tread_mps = plant.wheel_speeds_rad_s().left * 0.036;
    assert!(tread_mps > 5.0 * speed_mps, "{tread_mps}");
}

#[test]
fn slip_at_a_steady_speed_is_force_over_slip_stiffness() {
    let mut parameters = frictionless();
    parameters.caster.rolling_resistance = 0.2;
    let tyre = parameters.tyre;
    let slip_stiffness_n = tyre.longitudinal_stiffness_n_per_m * tyre.relaxation_length_m;
    let mut plant = robot(parameters);
    drive(&mut plant, 0.5, 0.5, 5_000_000);
    let tread_mps = plant.wheel_speeds_rad_s().left * 0.036;
    let slip = 1.0 - plant.twist().forward_mps / tread_mps;
    let force_n = 0.5 * 0.2 * plant.loads().caster_n;
    // Rolling resistance is 0.2 % short of its full value at this speed.
    assert!((slip / (force_n / slip_stiffness_n) - 1.0).abs() < 0.01, "{slip}");
    assert!(slip > 0.003, "enough of it to mean something: {slip}");
}

#[test]
fn a_robot_in_a_fast_turn_on_ice_slides_outwards() {
    let turn = |friction: f64| {
        let mut parameters = PlantParameters::default();
        parameters.floor.friction = friction;
        let mut plant = robot(parameters);
        drive(&mut plant, 0.25, 0.25, 6_000_000);
        drive(&mut plant, 0.0, 0.5, 500_000);
        plant.twist()
    };
    let (grippy, icy) = (turn(0.7), turn(0.01));
    assert!(grippy.left_mps.abs() < 0.01, "{grippy:?}");
    assert!(icy.yaw_rate_rad_s < 0.5 * grippy.yaw_rate_rad_s, "{icy:?} {grippy:?}");
}

#[test]
fn the_loads_carry_the_weight_and_shift_back_when_it_accelerates() {
    let mut plant = robot(PlantParameters::default());
    let weight_n = plant.parameters().body.mass_kg * plant.parameters().floor.gravity_mps2;
    let at_rest = plant.loads();
    // A quarter of the way to the caster: a quarter of the weight.
    assert!((at_rest.caster_n - 0.25 * weight_n).abs() < 1e-12);
    drive(&mut plant, 1.0, 1.0, 30_000);
    let pulling = plant.loads();
    let sum_n = pulling.driven_n.left + pulling.driven_n.right + pulling.caster_n;
    assert!((sum_n - weight_n).abs() < 1e-9);
    assert!(pulling.caster_n > at_rest.caster_n + 1.0, "{pulling:?}");
}
