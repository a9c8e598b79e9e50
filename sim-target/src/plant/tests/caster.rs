use core::f64::consts::PI;

use super::rig::{drive, robot};
use crate::plant::PlantParameters;

fn standard(start_angle_rad: f64) -> PlantParameters {
    let mut parameters = PlantParameters::default();
    parameters.caster.start_angle_rad = start_angle_rad;
    parameters
}

#[test]
fn a_caster_that_stands_across_swings_behind_the_robot() {
    let mut plant = robot(standard(1.5));
    drive(&mut plant, 0.2, 0.2, 5_000_000);
    // Its pivot's friction holds it a little off, and the robot's own curve a little more.
    assert!(plant.caster_angle_rad().abs() < 0.03, "{}", plant.caster_angle_rad());
}

#[test]
fn after_a_reversal_it_swings_round_and_kicks() {
    let reverse = |start_angle_rad: f64| {
        let mut parameters = standard(start_angle_rad);
        parameters.caster.swivel_friction_nm = 0.01;
        let mut plant = robot(parameters);
        drive(&mut plant, 0.2, 0.2, 2_000_000);
        drive(&mut plant, -0.2, -0.2, 6_000_000);
        let turned_rad = plant.caster_angle_rad().abs();
        assert!((turned_rad - PI).abs() < 0.3, "about half a turn: {turned_rad}");
        plant.pose().heading_rad
    };
    // The side it swings to is the side it stood on, and so is the kick.
    let (one, other) = (reverse(0.3), reverse(-0.3));
    println!("kick {one}");
    assert!(one.abs() > 0.01, "{one} rad");
    assert!((one + other).abs() < 1e-6, "{one}, {other}");
}

#[test]
fn on_a_perfectly_straight_course_nothing_decides_the_side_and_it_stays() {
    let mut plant = robot(standard(0.0));
    drive(&mut plant, -0.3, -0.3, 5_000_000);
    assert_eq!(plant.caster_angle_rad(), 0.0);
    assert_eq!(plant.pose().y_m, 0.0);
}

#[test]
fn its_pivots_friction_pulls_by_no_more_than_friction_over_trail() {
    let mut parameters = standard(0.3);
    parameters.caster.swivel_friction_nm = 0.004;
    let caster = parameters.caster;
    let tyre = parameters.tyre;
    let slip_stiffness_n = tyre.longitudinal_stiffness_n_per_m * tyre.relaxation_length_m;
    let track_m = parameters.geometry.track_width_m;
    let mut plant = robot(parameters);
    drive(&mut plant, 0.3, 0.3, 4_000_000);
    let spin = plant.wheel_speeds_rad_s();
    let rolled_rad_s = 0.036 * (spin.right - spin.left) / track_m;
    let slipped = (plant.twist().yaw_rate_rad_s - rolled_rad_s) / plant.twist().forward_mps;
    // Moment F (l + e) about the axle, carried by two tyres b apart: curvature 2 F (l + e) / (b^2 k sigma).
    let force_n = caster.swivel_friction_nm / caster.trail_m;
    let lever_m = caster.pivot_behind_m + caster.trail_m;
    let bound_per_m = 2.0 * force_n * lever_m / (track_m * track_m * slip_stiffness_n);
    assert!(slipped.abs() <= bound_per_m, "{slipped} of {bound_per_m}");
    assert!(
        slipped.abs() > 0.9 * bound_per_m,
        "friction does hold it off: {slipped}, {bound_per_m}"
    );
}
