//! Wheels, gears and what hangs on the robot: each against what geometry or statics expect of it.

use core::f64::consts::{FRAC_PI_2, TAU};

use shared_proto::WheelPair;

use super::rig::{drive, frictionless, robot};
use crate::plant::{GearParameters, Plant, PlantParameters, Pose, WetPatch, WheelParameters};

const RADIUS_M: f64 = 0.036;
const TRACK_M: f64 = 0.372;

/// Slip stiffness of a standard tyre along its way and across it, k sigma \[N\].
const ALONG_N: f64 = 20_000.0 * 0.012;
const ACROSS_N: f64 = 12_000.0 * 0.012;

fn both_wheels(wheel: WheelParameters) -> PlantParameters {
    PlantParameters { wheel: WheelPair::both(wheel), ..frictionless() }
}

/// Cruises for a second, and then returns what a whole second of cruise adds.
fn cruise(parameters: PlantParameters, left: f64, right: f64) -> (Plant, Pose, WheelPair<f64>) {
    let mut plant = robot(parameters);
    drive(&mut plant, left, right, 2_000_000);
    let (pose, angles) = (plant.pose(), plant.wheel_angles_rad());
    drive(&mut plant, left, right, 2_000_000);
    let turned = plant.wheel_angles_rad().zip(angles).map(|(now, then)| now - then);
    let way = plant.pose().relative_to(pose);
    (plant, way, turned)
}

/// Heading by the wheels' turns alone.
fn rolled_rad(turned: WheelPair<f64>) -> f64 {
    RADIUS_M * (turned.right - turned.left) / TRACK_M
}

#[test]
fn a_defect_that_touches_nothing_leaves_the_motion_the_same_to_the_last_bit() {
    let mut far = PlantParameters::default();
    far.floor.wet = Some(WetPatch { x_m: 50.0, y_m: 0.0, radius_m: 1.0, friction: 0.1 });
    let (mut ideal, mut defective) = (robot(PlantParameters::default()), robot(far));
    for plant in [&mut ideal, &mut defective] {
        drive(plant, 0.5, 0.3, 2_000_000);
        drive(plant, -0.4, 0.4, 1_000_000);
        drive(plant, 0.0, 0.0, 500_000);
    }
    assert_eq!(ideal.pose(), defective.pose());
    assert_eq!(ideal.counts(), defective.counts());
    assert_eq!(ideal.energy_j(), defective.energy_j());
}

#[test]
fn a_rim_off_its_hub_rolls_farther_while_the_hub_is_high() {
    let (e, phase) = (0.01, 0.7);
    let wheel = WheelParameters {
        eccentricity: e,
        eccentricity_phase_rad: phase,
        ..WheelParameters::default()
    };
    let mut plant = robot(both_wheels(wheel));
    let (mut worst_m, mut largest_m) = (0.0_f64, 0.0_f64);
    for step in 0..350 {
        // A soft start: the tyres' own deflection under a hard one is 0.3 mm.
        let duty = 0.15 * (f64::from(step) / 100.0).min(1.0);
        drive(&mut plant, duty, duty, 10_000);
        let phi = plant.wheel_angles_rad().left;
        // The integral of the hub's height over the angle.
        let expected_m = RADIUS_M * (phi + e * ((phi - phase).sin() + phase.sin()));
        worst_m = worst_m.max((plant.pose().x_m - expected_m).abs());
        largest_m = largest_m.max((plant.pose().x_m - RADIUS_M * phi).abs());
    }
    // The rest is what the tyres slip while the robot gathers speed, 2e-5 m, and bend.
    assert!(worst_m < 4e-5, "{worst_m}");
    assert!(largest_m > 4e-4, "{largest_m}");
}

#[test]
fn a_tyre_that_grows_rolls_farther_by_the_square_of_its_spin() {
    let wheel = WheelParameters { centrifugal_growth_s2: 1e-4, ..WheelParameters::default() };
    for duty in [0.4, 0.8] {
        let (plant, way, turned) = cruise(both_wheels(wheel), duty, duty);
        let expected = 1e-4 * plant.wheel_speeds_rad_s().left.powi(2);
        let growth = way.x_m / (RADIUS_M * turned.left) - 1.0;
        // Two seconds after the start the last per cent of speed is still to come.
        assert!((growth / expected - 1.0).abs() < 0.03, "{growth}, {expected}");
    }
}

#[test]
fn a_payload_presses_the_wheels_down_by_its_share_of_the_weight() {
    let c = 5e-6;
    let wheel = WheelParameters { radial_compliance_m_per_n: c, ..WheelParameters::default() };
    let roll = |payload_kg: f64| {
        let mut parameters = both_wheels(wheel);
        parameters.body.payload_kg = payload_kg;
        let (_, way, turned) = cruise(parameters, 0.5, 0.5);
        way.x_m / (RADIUS_M * turned.left) - 1.0
    };
    // Over the centre of mass, a quarter of it stands on the caster.
    let expected = -c * 10.0 * 9.81 * 0.75 / 2.0 / RADIUS_M;
    assert!((roll(10.0) / expected - 1.0).abs() < 0.03, "{}, {expected}", roll(10.0));
    assert!(roll(0.0).abs() < 1e-4, "unladen it is as wide as declared: {}", roll(0.0));
    let mut set = robot(both_wheels(wheel));
    set.set_payload(10.0);
    assert_eq!(set.parameters().body.payload_kg, 10.0);
    let driven_n = set.loads().driven_n;
    assert!((driven_n.left + driven_n.right - 0.75 * 14.0 * 9.81).abs() < 1e-9);
}

#[test]
fn load_transfer_in_a_fast_turn_makes_it_wider_by_the_square_of_speed() {
    let c = 7e-5;
    let turn = |c: f64| {
        let wheel = WheelParameters { radial_compliance_m_per_n: c, ..WheelParameters::default() };
        let mut parameters = both_wheels(wheel);
        parameters.body.center_of_mass_height_m = 0.3;
        let (plant, way, turned) = cruise(parameters, 0.55, 0.85);
        (way.heading_rad / rolled_rad(turned) - 1.0, plant.twist().forward_mps)
    };
    let ((soft, v_mps), (hard, _)) = (turn(c), turn(0.0));
    // dN = m v omega h/b on each side; R loses c dN outside and gains it inside.
    let expected = -2.0 * c * 4.0 * 0.3 * v_mps * v_mps / (TRACK_M * TRACK_M * RADIUS_M);
    assert!(expected < -0.002, "{expected}");
    // The longer way of the tread changes the tyres' slip a little as well.
    assert!(((soft - hard) / expected - 1.0).abs() < 0.1, "{soft} {hard} {expected}");
}

#[test]
fn bent_axles_swing_the_robot_from_side_to_side_once_a_turn() {
    let wheel = WheelParameters { bend_rad: 0.08, ..WheelParameters::default() };
    let mut plant = robot(both_wheels(wheel));
    let mut most_m = 0.0_f64;
    for _ in 0..500 {
        drive(&mut plant, 0.12, 0.12, 10_000);
        most_m = most_m.max(plant.pose().y_m.abs());
    }
    assert!(plant.wheel_angles_rad().left > TAU, "a whole turn");
    // dy = R beta cos(phi) dphi; tyres follow at a lag of their relaxation length over the radius.
    let expected_m = RADIUS_M * 0.08;
    assert!((most_m / expected_m - 1.0).abs() < 0.1, "{most_m}, {expected_m}");
}

#[test]
fn a_flat_spot_costs_its_shadow_once_a_turn() {
    let lost_m = |alpha: f64| {
        let wheel = WheelParameters { flat_half_angle_rad: alpha, ..WheelParameters::default() };
        let mut plant = robot(both_wheels(wheel));
        while plant.wheel_angles_rad().left < 4.0 * TAU {
            drive(&mut plant, 0.2, 0.2, 1_000);
        }
        RADIUS_M * plant.wheel_angles_rad().left - plant.pose().x_m
    };
    // The hub over the flat is at R cos(alpha)/cos(psi), which integrates to a logarithm.
    let alpha = 0.2_f64;
    let over_flat = 2.0 * alpha.cos() * (FRAC_PI_2 / 2.0 + alpha / 2.0).tan().ln();
    let expected_m = 4.0 * RADIUS_M * (2.0 * alpha - over_flat);
    let lost_m = lost_m(alpha) - lost_m(0.0);
    // Slip is in proportion to speed, and the tread is slower while it pushes: some per cent.
    assert!((lost_m / expected_m - 1.0).abs() < 0.1, "{lost_m}, {expected_m}");
}

#[test]
fn a_wheel_with_end_float_is_farther_out_in_one_direction_of_turning() {
    let mut parameters = frictionless();
    parameters.wheel.left.end_float_m = 0.004;
    parameters.wheel.left.contact_ahead_m = 0.01;
    let track = |sign: f64| {
        let (_, way, turned) = cruise(parameters.clone(), -0.3 * sign, 0.3 * sign);
        TRACK_M * rolled_rad(turned) / way.heading_rad
    };
    let (left_m, right_m) = (track(1.0), track(-1.0));
    // The contact stands in front: turning left, the floor pushes the left wheel inwards.
    assert!((left_m - right_m + 0.004).abs() < 4e-4, "{left_m} {right_m}");
    assert!((0.5 * (left_m + right_m) - TRACK_M).abs() < 0.001, "{left_m} {right_m}");
}

#[test]
fn play_is_crossed_by_the_shaft_alone_and_the_floor_drags_the_wheel() {
    let gear = GearParameters { backlash_rad: 0.04, set_screw_nm: None };
    let mut plant =
        robot(PlantParameters { gear: WheelPair::both(gear), ..PlantParameters::default() });
    let ahead = |plant: &Plant| plant.shaft_angles_rad().left - plant.wheel_angles_rad().left;
    drive(&mut plant, 0.3, 0.3, 1_000_000);
    assert!((ahead(&plant) - 0.02).abs() < 1e-12, "on the driving flank: {}", ahead(&plant));
    drive(&mut plant, 0.0, 0.0, 1_000_000);
    // A short-circuited motor brakes: the robot's momentum has pushed the wheel to the other flank.
    // Its tyres' last spring back takes it off that flank again, by less than 0.2 mm of tread.
    assert!((ahead(&plant) + 0.02).abs() < 0.005, "near the braking flank: {}", ahead(&plant));
    let (stood, shaft) = (plant.wheel_angles_rad().left, plant.shaft_angles_rad().left);
    drive(&mut plant, 0.06, 0.06, 30_000);
    assert!(plant.shaft_angles_rad().left > shaft + 1e-3, "the motor turns");
    assert!((plant.wheel_angles_rad().left - stood).abs() < 1e-9, "the wheel does not");
    drive(&mut plant, -0.3, -0.3, 1_000_000);
    assert!((ahead(&plant) + 0.02).abs() < 1e-12, "on the other flank: {}", ahead(&plant));
    // A rigid robot on the same duties ends as far along, but for the play.
    let mut rigid = robot(PlantParameters::default());
    for (duty, us) in [(0.3, 1_000_000), (0.0, 1_000_000), (0.06, 30_000), (-0.3, 1_000_000)] {
        drive(&mut rigid, duty, duty, us);
    }
    assert!((rigid.pose().x_m - plant.pose().x_m).abs() < 2.0 * 0.04 * RADIUS_M);
}

#[test]
fn a_set_screw_slips_above_its_torque_and_not_below() {
    let gear = GearParameters { backlash_rad: 0.0, set_screw_nm: Some(0.03) };
    let mut parameters = frictionless();
    parameters.gear.left = gear;
    // Gently to 0.05 m/s takes some milli-newton-metres; at once to full speed, a hundred times that.
    let mut plant = robot(parameters.clone());
    for ms in 1..=3000 {
        let duty = 0.1 * (f64::from(ms) / 2000.0).min(1.0);
        drive(&mut plant, duty, duty, 1000);
    }
    assert_eq!(plant.shaft_angles_rad().left, plant.wheel_angles_rad().left);
    let mut plant = robot(parameters.clone());
    drive(&mut plant, 1.0, 1.0, 100_000);
    let slipped = plant.shaft_angles_rad().left - plant.wheel_angles_rad().left;
    assert!(slipped > 0.1, "{slipped}");
    // What gets through moves the wheel: its side cannot pull harder than the screw.
    assert!(plant.pose().heading_rad > 0.01, "it turns to the slipping side: {:?}", plant.pose());
}

#[test]
fn a_twisted_tether_turns_the_robot_alike_forwards_and_backwards() {
    let twist_nm = 0.05;
    let mut parameters = frictionless();
    parameters.tether.twist_nm = twist_nm;
    for duty in [0.4, -0.4] {
        let (_, way, turned) = cruise(parameters.clone(), duty, duty);
        let pulled = (way.heading_rad - rolled_rad(turned)) / way.x_m.abs();
        // Two wheels carry M/b each, and slip by their share of k sigma.
        let expected = 2.0 * twist_nm / (TRACK_M * TRACK_M * ALONG_N);
        assert!((pulled / expected - 1.0).abs() < 0.02, "{pulled}, {expected}, duty {duty}");
    }
}

#[test]
fn what_drags_at_one_side_turns_the_robot_to_that_side_and_back() {
    let mut parameters = frictionless();
    parameters.drag.force_n = 1.0;
    parameters.drag.left_m = 0.15;
    for duty in [0.4, -0.4] {
        let (_, way, turned) = cruise(parameters.clone(), duty, duty);
        let pulled = (way.heading_rad - rolled_rad(turned)) / way.x_m;
        let expected = 2.0 * 0.15 / (TRACK_M * TRACK_M * ALONG_N);
        // A caster that has just been turned round by the drag takes a few per cent.
        assert!((pulled / expected - 1.0).abs() < 0.05, "{pulled}, {expected}, duty {duty}");
    }
}

#[test]
fn a_pull_from_the_side_is_carried_by_a_slip_angle() {
    let mut parameters = frictionless();
    parameters.tether.left_n = 0.5;
    for duty in [0.4, -0.4] {
        let (_, way, _) = cruise(parameters.clone(), duty, duty);
        let expected = 0.5 / (2.0 * ACROSS_N);
        assert!((way.y_m / way.x_m.abs() / expected - 1.0).abs() < 0.03, "{way:?} {expected}");
    }
}

#[test]
fn wheels_from_the_cold_grow_towards_the_rooms_temperature() {
    let rolled = |age_s: f64| {
        let mut parameters = frictionless();
        parameters.warming.expansion_per_k = 2e-4;
        parameters.warming.difference_k = 20.0;
        parameters.warming.time_constant_s = 1800.0;
        parameters.warming.age_s = age_s;
        let (_, way, turned) = cruise(parameters, 0.5, 0.5);
        way.x_m / (RADIUS_M * turned.left) - 1.0
    };
    for age_s in [0.0_f64, 1800.0, 1e6] {
        let expected = 4e-3 * (1.0 - (-age_s / 1800.0).exp());
        // Slip of the last of the acceleration, and two seconds of warming.
        assert!((rolled(age_s) - expected).abs() < 4e-5, "{age_s}: {}", rolled(age_s));
    }
}
