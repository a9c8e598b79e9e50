use core::f64::consts::PI;

use shared_proto::WheelPair;

use super::rig::{drive, drive_paper_run, robot};
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

#[test]
fn a_wheel_that_leans_trails_aside_without_a_force_and_swings_the_same_way_after_each_reversal() {
    let mut parameters = standard(0.0);
    parameters.caster.conicity_rad = 0.1;
    parameters.caster.swivel_friction_nm = 0.0;
    let mut plant = robot(parameters);
    drive_paper_run(&mut plant, WheelPair::both(1.0), 1.5);
    // Rolling at the slip angle that makes up for its push, whose tangent is the conicity.
    let trails_rad = plant.caster_angle_rad();
    assert!((trails_rad + 0.1_f64.atan()).abs() < 1e-3, "{trails_rad}");
    let ahead_rad = plant.pose().heading_rad;
    // It was set straight at the start, and swung by a tenth of a radian.
    assert!(ahead_rad.abs() < 1e-3, "{ahead_rad}");
    drive_paper_run(&mut plant, WheelPair::both(-1.0), 1.5);
    let back_rad = plant.caster_angle_rad() - trails_rad;
    assert!((back_rad + PI).abs() < 0.01, "half a turn clockwise: {back_rad}");
    drive_paper_run(&mut plant, WheelPair::both(1.0), 1.5);
    let again_rad = plant.caster_angle_rad() - trails_rad;
    assert!((again_rad + 2.0 * PI).abs() < 0.01, "and on: {again_rad}");
}

/// What a reversal turns the robot more with a bush of this torque than without one, on tyres this stiff along
/// their way \[rad\]. The bush is stiff and relaxes at once where nothing swings.
fn kick_rad(torque_nm: f64, stiffness_n_per_m: f64, lean: f64) -> f64 {
    let turned_rad = |torque_nm: f64| {
        let mut parameters = standard(0.0);
        parameters.substep_us = 200;
        let caster = &mut parameters.caster;
        (caster.pivot_behind_m, caster.trail_m) = (0.12, 0.1);
        (caster.swivel_inertia_kgm2, caster.conicity_rad) = (2e-4, 0.1 * lean);
        caster.bush.torque_nm = torque_nm;
        parameters.tyre.longitudinal_stiffness_n_per_m = stiffness_n_per_m;
        parameters.tyre.lateral_stiffness_n_per_m = 70_000.0;
        parameters.tyre.relaxation_length_m = 0.05;
        let mut plant = robot(parameters);
        drive_paper_run(&mut plant, WheelPair::both(1.0), 1.5);
        let before_rad = plant.pose().heading_rad;
        drive_paper_run(&mut plant, WheelPair::both(-1.0), 1.5);
        let rolled = plant.wheel_angles_rad();
        plant.pose().heading_rad - before_rad - 0.036 * (rolled.right - rolled.left) / 0.372
    };
    turned_rad(torque_nm) - turned_rad(0.0)
}

#[test]
fn a_stiff_bush_kicks_in_proportion_to_its_torque_and_to_what_the_tyres_give() {
    let kick = kick_rad(0.3, 20_000.0, 1.0);
    println!("kick {kick}");
    // Clockwise with the fork. Between two and eight trails of way, 2 T/(b^2 k sigma) rad/m.
    let per_m = 2.0 * 0.3 / (0.372 * 0.372 * 1000.0);
    assert!((2.0..8.0).contains(&(-kick / (0.1 * per_m))), "{kick} at {per_m} rad/m");
    let twice = kick_rad(0.6, 20_000.0, 1.0) / kick;
    assert!((1.6..2.2).contains(&twice), "twice the torque: {twice}");
    let softer = kick_rad(0.3, 10_000.0, 1.0) / kick;
    assert!((1.8..2.2).contains(&softer), "half the stiffness: {softer}");
    let mirrored = kick_rad(0.3, 20_000.0, -1.0) / kick;
    assert!((mirrored + 1.0).abs() < 0.01, "leaning to the other side: {mirrored}");
}

#[test]
fn a_caster_turned_by_hand_trails() {
    let mut plant = robot(standard(2.0));
    assert_eq!(plant.caster_angle_rad(), 2.0);
    plant.trail_caster();
    assert_eq!(plant.caster_angle_rad(), 0.0);
    drive(&mut plant, 0.2, 0.2, 2_000_000);
    assert_eq!(plant.caster_angle_rad(), 0.0, "and stays there on a straight course");
}
