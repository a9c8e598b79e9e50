use super::rig::{drive, robot};
use crate::plant::{Plant, PlantParameters, Pose};

#[test]
fn a_robot_at_rest_stays_at_rest_to_the_last_bit() {
    let start = Pose { x_m: 1.0, y_m: -2.0, heading_rad: 0.7 };
    let mut plant = Plant::new(PlantParameters::default(), start, 3);
    let (pose, counts) = (plant.pose(), plant.counts());
    plant.set_enabled(true);
    plant.advance_to(60_000_000);
    assert_eq!(plant.pose(), pose);
    assert_eq!(plant.counts(), counts);
    assert_eq!(plant.energy_j(), 0.0);
}

#[test]
fn a_duty_below_friction_moves_nothing_however_long() {
    let mut plant = robot(PlantParameters::default());
    // Friction takes 4 % of duty.
    drive(&mut plant, 0.03, 0.03, 60_000_000);
    assert_eq!(plant.pose(), Pose::default());
    assert_eq!(plant.wheel_angles_rad().left, 0.0);
    assert!(plant.currents_a().left > 0.04, "the motor does pull: {:?}", plant.currents_a());
}

#[test]
fn a_robot_that_was_stopped_does_not_creep() {
    let mut plant = robot(PlantParameters::default());
    drive(&mut plant, 0.4, 0.3, 2_000_000);
    drive(&mut plant, 0.0, 0.0, 2_000_000);
    let pose = plant.pose();
    drive(&mut plant, 0.0, 0.0, 120_000_000);
    let crept_m = (plant.pose().x_m - pose.x_m).hypot(plant.pose().y_m - pose.y_m);
    // What is left of the tyres' vibration after two seconds is far below an atom.
    assert!(crept_m < 1e-9, "{crept_m} m in two minutes");
    assert!((plant.pose().heading_rad - pose.heading_rad).abs() < 1e-9);
}

#[test]
fn coasting_loses_energy_all_the_time_and_stops() {
    let mut plant = robot(PlantParameters::default());
    drive(&mut plant, 0.8, 0.6, 2_000_000);
    plant.set_enabled(false);
    let from_x_m = plant.pose().x_m;
    let mut energy_j = plant.energy_j();
    assert!(energy_j > 0.2, "it moves at first: {energy_j} J");
    for ms in 0..4000 {
        plant.advance_to(2_001_000 + ms * 1000);
        let now_j = plant.energy_j();
        // Leapfrog's energy swings about the true one by (w h)^2 / 8 of what vibrates, and that is
        // less than 1 mJ here: 4 uJ.
        assert!(now_j < energy_j + 4e-6, "{energy_j} -> {now_j} J at {ms} ms");
        energy_j = now_j;
    }
    assert_eq!(plant.wheel_speeds_rad_s().left, 0.0);
    assert_eq!(plant.wheel_speeds_rad_s().right, 0.0);
    assert!(plant.twist().forward_mps.abs() < 1e-9);
    let rolled_m = (plant.pose().x_m - from_x_m).abs();
    assert!(rolled_m > 0.05, "it coasts and does not stop dead: {rolled_m} m");
}

#[test]
fn a_robot_that_is_put_down_elsewhere_is_at_rest_there_and_keeps_its_counts() {
    let mut plant = robot(PlantParameters::default());
    drive(&mut plant, 0.5, 0.5, 1_000_000);
    let counts = plant.counts();
    let there = Pose { x_m: -1.0, y_m: 4.0, heading_rad: 1.0 };
    plant.set_enabled(false);
    plant.place(there);
    plant.advance_to(2_000_000);
    assert!((plant.pose().x_m - there.x_m).abs() < 1e-12);
    assert!((plant.pose().y_m - there.y_m).abs() < 1e-12);
    assert_eq!(plant.counts(), counts);
    assert_eq!(plant.energy_j(), 0.0);
}
