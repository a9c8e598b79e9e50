use shared_proto::WheelPair;

use super::rig::{drive, drive_paper_run, frictionless, robot};
use crate::plant::{Plant, PlantParameters, Pose};

const GAIN: f64 = 1.5;
const FORWARD: WheelPair<f64> = WheelPair::new(1.0, 1.0);
const BACKWARD: WheelPair<f64> = WheelPair::new(-1.0, -1.0);

/// The paper's wheels, on a robot that nothing else pulls aside.
fn unequal() -> PlantParameters {
    let mut parameters = frictionless();
    parameters.geometry.wheel_radius_m.right = 0.036 * 0.9919;
    parameters
}

/// Heading by kinematics alone: (R_R phi_R - R_L phi_L) / b.
fn rolled_heading_rad(plant: &Plant) -> f64 {
    let geometry = plant.parameters().geometry;
    let phi = plant.wheel_angles_rad();
    let radius = geometry.wheel_radius_m;
    (radius.right * phi.right - radius.left * phi.left) / geometry.track_width_m
}

#[test]
fn unequal_wheels_curve_by_their_difference_over_the_track() {
    let mut plant = robot(unequal());
    drive_paper_run(&mut plant, FORWARD, GAIN);
    let expected_rad = rolled_heading_rad(&plant);
    let heading_rad = plant.pose().heading_rad;
    assert!((expected_rad + 0.0394).abs() < 2e-4, "the paper's 0.0396, at its W_T: {expected_rad}");
    // Nothing but tyre compliance stands between the two.
    assert!((heading_rad / expected_rad - 1.0).abs() < 0.005, "{heading_rad}, {expected_rad}");
    assert!((plant.pose().y_m + 0.0355).abs() < 0.0005, "{:?}", plant.pose());
}

#[test]
fn going_backwards_flips_the_turn() {
    let mut forward = robot(unequal());
    drive_paper_run(&mut forward, FORWARD, GAIN);
    let mut backward = robot(unequal());
    drive_paper_run(&mut backward, BACKWARD, GAIN);
    let (there, back) = (forward.pose().heading_rad, backward.pose().heading_rad);
    assert!(there < -0.03 && back > 0.03, "{there}, {back}");
    // The caster swings round on the way back, which costs a little.
    assert!((back / rolled_heading_rad(&backward) - 1.0).abs() < 0.02, "{back}");
}

#[test]
fn a_spin_turns_by_the_wheels_travel_over_the_track() {
    let mut plant = robot(frictionless());
    drive_paper_run(&mut plant, WheelPair::new(-1.0, 1.0), GAIN);
    let (heading_rad, expected_rad) = (plant.pose().heading_rad, rolled_heading_rad(&plant));
    assert!((heading_rad / expected_rad - 1.0).abs() < 0.005, "{heading_rad}, {expected_rad}");
    // With its mass behind the axle it is swung outwards, by about a millimetre.
    assert!(plant.pose().x_m.hypot(plant.pose().y_m) < 0.005, "{:?}", plant.pose());
}

#[test]
fn the_mirrored_robot_drives_the_mirrored_path() {
    let mut parameters = PlantParameters::default();
    parameters.geometry.wheel_radius_m = WheelPair::new(0.0361, 0.0357);
    parameters.motor.left.coulomb_torque_nm = 0.06;
    parameters.body.center_of_mass_left_m = 0.01;
    parameters.caster.start_angle_rad = 0.4;
    let swap = |pair: WheelPair<f64>| WheelPair::new(pair.right, pair.left);
    let mut mirrored = parameters.clone();
    mirrored.geometry.wheel_radius_m = swap(parameters.geometry.wheel_radius_m);
    mirrored.motor = WheelPair::new(parameters.motor.right, parameters.motor.left);
    mirrored.body.center_of_mass_left_m *= -1.0;
    mirrored.caster.start_angle_rad *= -1.0;
    let (mut plant, mut mirror) = (robot(parameters), robot(mirrored));
    for (left, right) in [(0.3, 0.5), (-0.4, 0.1), (1.0, 0.8)] {
        drive(&mut plant, left, right, 1_000_000);
        drive(&mut mirror, right, left, 1_000_000);
    }
    let (a, b) = (plant.pose(), mirror.pose());
    // Sums are rounded in another order, and the reversal makes more of that.
    assert!((a.x_m - b.x_m).abs() < 1e-9, "{a:?} {b:?}");
    assert!((a.y_m + b.y_m).abs() < 1e-9, "{a:?} {b:?}");
    assert!((a.heading_rad + b.heading_rad).abs() < 1e-9, "{a:?} {b:?}");
    assert!(a.heading_rad.abs() > 0.1);
}

#[test]
fn the_path_does_not_depend_on_where_it_starts() {
    let start = Pose { x_m: 3.0, y_m: -7.0, heading_rad: 2.5 };
    let mut here = robot(unequal());
    let mut there = Plant::new(unequal(), start, 1);
    for plant in [&mut here, &mut there] {
        drive(plant, 0.5, 0.4, 3_000_000);
    }
    let (a, b) = (here.pose(), there.pose().relative_to(start));
    assert!((a.x_m - b.x_m).abs() < 1e-9 && (a.y_m - b.y_m).abs() < 1e-9, "{a:?} {b:?}");
    assert!((a.heading_rad - b.heading_rad).abs() < 1e-9);
}
