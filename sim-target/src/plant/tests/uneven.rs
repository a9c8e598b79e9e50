//! Floors and tyres: each against what statics expect of it.

use core::f64::consts::{FRAC_PI_2, PI};

use super::rig::{drive, frictionless, robot};
use crate::plant::{Bump, Plant, PlantParameters, Pose, WetPatch};

const RADIUS_M: f64 = 0.036;
const TRACK_M: f64 = 0.372;
const ALONG_N: f64 = 20_000.0 * 0.012;
const ACROSS_N: f64 = 12_000.0 * 0.012;

/// What two seconds of cruise add, after two of getting there; and the heading by the wheels alone.
fn cruise(parameters: &PlantParameters, start_rad: f64, left: f64, right: f64) -> (Pose, f64) {
    let start = Pose { heading_rad: start_rad, ..Pose::default() };
    let mut plant = Plant::new(parameters.clone(), start, 1);
    drive(&mut plant, left, right, 2_000_000);
    let (pose, angles) = (plant.pose(), plant.wheel_angles_rad());
    drive(&mut plant, left, right, 2_000_000);
    let turned = plant.wheel_angles_rad().zip(angles).map(|(now, then)| now - then);
    (plant.pose().relative_to(pose), RADIUS_M * (turned.right - turned.left) / TRACK_M)
}

#[test]
fn across_a_slope_the_robot_creeps_down_and_its_tail_swings_downhill() {
    let mut parameters = frictionless();
    parameters.floor.slope_rad = 0.03;
    let down_n = 4.0 * 9.81 * 0.03_f64.sin();
    for (downhill_rad, side) in [(-FRAC_PI_2, -1.0), (FRAC_PI_2, 1.0)] {
        parameters.floor.downhill_rad = downhill_rad;
        for duty in [0.4, -0.4] {
            let (way, rolled_rad) = cruise(&parameters, 0.0, duty, duty);
            let turn_per_m = (way.heading_rad - rolled_rad) / way.x_m.abs();
            let expected_turn = -side * 2.0 * 0.05 * down_n / (TRACK_M * TRACK_M * ALONG_N);
            assert!((turn_per_m / expected_turn - 1.0).abs() < 0.03, "{turn_per_m}");
            // The turn moves it sideways as well: half of it per metre on the way, and what came before.
            let creep = (way.y_m - 0.5 * way.heading_rad * way.x_m) / way.x_m.abs();
            let expected = side * down_n / (2.0 * ACROSS_N);
            assert!((creep / expected - 1.0).abs() < 0.05, "{creep}, {expected}");
        }
    }
}

#[test]
fn uphill_it_lags_and_downhill_it_leads() {
    let mut parameters = frictionless();
    parameters.floor.slope_rad = 0.03;
    parameters.floor.downhill_rad = PI;
    let mut plant = robot(parameters);
    drive(&mut plant, 0.5, 0.5, 2_000_000);
    let (x_m, phi) = (plant.pose().x_m, plant.wheel_angles_rad().left);
    drive(&mut plant, 0.5, 0.5, 2_000_000);
    let way_m = plant.pose().x_m - x_m;
    let slip = way_m / (RADIUS_M * (plant.wheel_angles_rad().left - phi)) - 1.0;
    let expected = -4.0 * 9.81 * 0.03_f64.sin() / (2.0 * ALONG_N);
    assert!((slip / expected - 1.0).abs() < 0.03, "{slip}, {expected}");
}

#[test]
fn a_carpets_pile_carries_the_robot_one_way_whatever_its_heading_and_does_not_turn_it() {
    let mut parameters = frictionless();
    parameters.floor.pile_drift = 0.01;
    parameters.floor.pile_direction_rad = 0.5;
    for start_rad in [0.0, 2.0, -2.5] {
        for duty in [0.4, -0.4] {
            let (way, _) = cruise(&parameters, start_rad, duty, duty);
            let (bare, _) = cruise(&frictionless(), start_rad, duty, duty);
            let rolled_m = bare.x_m.abs();
            let direction = 0.5 - start_rad;
            let expected = (0.01 * rolled_m * direction.cos(), 0.01 * rolled_m * direction.sin());
            // Spin differs by what the floor gives or takes: 1 % of 1 %.
            assert!((way.x_m - bare.x_m - expected.0).abs() < 3e-4 * rolled_m, "{way:?}");
            assert!((way.y_m - bare.y_m - expected.1).abs() < 3e-4 * rolled_m, "{way:?}");
            assert!((way.heading_rad - bare.heading_rad).abs() < 2e-4, "{way:?}");
        }
    }
}

#[test]
fn a_tyre_on_a_film_creeps_sideways_at_a_speed_in_proportion_to_the_side_force() {
    let k_s = 0.02;
    let mut parameters = frictionless();
    parameters.tyre.lateral_creep_mps_per_n = 2.0 * k_s / 4.0;
    for (left, right) in [(0.3, 0.5), (0.6, 0.4)] {
        let mut plant = robot(parameters.clone());
        drive(&mut plant, left, right, 3_000_000);
        let twist = plant.twist();
        // The force makes the circle of the centre of mass, which is 5 cm behind: it slips once more.
        let rolling = 4.0 * twist.forward_mps / (2.0 * ACROSS_N);
        let expected = -(k_s + rolling) * twist.forward_mps * twist.yaw_rate_rad_s;
        assert!((twist.left_mps / expected - 1.0).abs() < 0.05, "{twist:?} {expected}");
    }
}

#[test]
fn accelerating_wheels_run_ahead_of_the_ground_by_force_over_slip_stiffness() {
    for factor in [1.0, 3.0] {
        let mut parameters = frictionless();
        parameters.tyre.longitudinal_stiffness_n_per_m /= factor;
        let mut plant = robot(parameters);
        for ms in 0..1500 {
            let duty = 0.1 + 4e-4 * f64::from(ms);
            drive(&mut plant, duty, duty, 1000);
        }
        let (x_m, phi) = (plant.pose().x_m, plant.wheel_angles_rad().left);
        let before_mps = plant.twist().forward_mps;
        for ms in 1500..1700 {
            let duty = 0.1 + 4e-4 * f64::from(ms);
            drive(&mut plant, duty, duty, 1000);
        }
        let a_mps2 = (plant.twist().forward_mps - before_mps) / 0.2;
        let way_m = plant.pose().x_m - x_m;
        let slip = 1.0 - way_m / (RADIUS_M * (plant.wheel_angles_rad().left - phi));
        let expected = factor * 4.0 * a_mps2 / (2.0 * ALONG_N);
        assert!((0.0005..0.05).contains(&expected), "{a_mps2}");
        assert!((slip / expected - 1.0).abs() < 0.05, "{slip}, {expected}");
    }
}

#[test]
fn a_wide_tyre_makes_the_track_seem_wider_and_most_in_tight_turns() {
    let width_m = 0.06;
    let widening = |left: f64, right: f64| {
        let mut parameters = frictionless();
        parameters.tyre.contact_width_m = width_m;
        let (wide, rolled_rad) = cruise(&parameters, 0.0, left, right);
        let (narrow, narrow_rolled_rad) = cruise(&frictionless(), 0.0, left, right);
        rolled_rad / wide.heading_rad - narrow_rolled_rad / narrow.heading_rad
    };
    // A radius of 3 m: every rib holds, and the share is w^2/(2 b^2).
    let expected = 0.5 * (width_m / TRACK_M).powi(2);
    let (gentle, spin) = (widening(0.47, 0.53), widening(-0.4, 0.4));
    println!("gentle {gentle:.5} of {expected:.5}, spin {spin:.5}");
    assert!((gentle / expected - 1.0).abs() < 0.05, "{gentle}, {expected}");
    // Ribs at the edges slide: 4 of them with 0.3 mu N w a wheel, held by the middle one alone.
    let load_n = 0.5 * 0.75 * 4.0 * 9.81;
    let sliding = 0.6 * 0.7 * load_n * width_m / (TRACK_M * ALONG_N / 5.0);
    assert!((spin / sliding - 1.0).abs() < 0.15, "{spin}, {sliding}");
    assert!(spin > 1.3 * gentle, "{spin}, {gentle}");
}

#[test]
fn a_bump_in_one_wheels_way_costs_it_way_and_turns_the_robot_to_its_side() {
    let mut parameters = frictionless();
    let bump = Bump { x_m: 0.3, y_m: 0.186, radius_m: 0.05, height_m: 0.01 };
    parameters.floor.bump = Some(bump);
    let mut plant = robot(parameters);
    drive(&mut plant, 0.3, 0.3, 4_000_000);
    assert!(plant.pose().x_m > 0.4, "it gets over: {:?}", plant.pose());
    let turned = plant.wheel_angles_rad();
    let rolled_rad = RADIUS_M * (turned.right - turned.left) / TRACK_M;
    // The path over the bump is longer than its foot: the integral of sqrt(1 + z'^2) - 1.
    let n = 10_000;
    let longer_m: f64 = (0..n)
        .map(|i| {
            let r = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(n);
            let slope = -4.0 * bump.height_m / bump.radius_m * r * (1.0 - r * r);
            ((1.0 + slope * slope).sqrt() - 1.0) * 2.0 * bump.radius_m / f64::from(n)
        })
        .sum();
    let expected_rad = longer_m / TRACK_M;
    let turned_rad = plant.pose().heading_rad - rolled_rad;
    // What it takes to climb it gives back behind, but for the tyres' slip under that force.
    assert!((turned_rad / expected_rad - 1.0).abs() < 0.2, "{turned_rad}, {expected_rad}");
}

#[test]
fn a_wheel_on_a_wet_patch_slides_where_the_other_holds() {
    let mut parameters = frictionless();
    parameters.floor.wet = Some(WetPatch { x_m: 0.0, y_m: 0.3, radius_m: 0.2, friction: 0.01 });
    let mut plant = robot(parameters);
    drive(&mut plant, 0.4, 0.4, 300_000);
    let spin = plant.wheel_speeds_rad_s();
    let hub_mps = plant.twist().forward_mps - 0.186 * plant.twist().yaw_rate_rad_s;
    assert!(RADIUS_M * spin.left > hub_mps + 0.02, "{spin:?} {:?}", plant.twist());
    assert!(plant.pose().heading_rad > 0.005, "to the wet side: {:?}", plant.pose());
}

#[test]
fn on_a_slope_a_robot_at_rest_stays() {
    let mut parameters = PlantParameters::default();
    parameters.floor.slope_rad = 0.05;
    let mut plant = robot(parameters);
    drive(&mut plant, 0.0, 0.0, 1_000_000);
    let pose = plant.pose();
    drive(&mut plant, 0.0, 0.0, 10_000_000);
    assert!((plant.pose().x_m - pose.x_m).abs() < 1e-9, "{pose:?} {:?}", plant.pose());
}
