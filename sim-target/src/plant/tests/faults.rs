use shared_proto::Wheel;

use super::rig::{drive, robot};
use crate::plant::{Plant, PlantFault, PlantParameters};

/// The standard robot at the paper's cruising speed.
fn cruising() -> Plant {
    let mut plant = robot(PlantParameters::default());
    drive(&mut plant, 0.273, 0.273, 3_000_000);
    plant
}

#[test]
fn a_hand_stops_the_wheel_within_its_grip_time_but_not_at_once() {
    let mut plant = cruising();
    let at_us = plant.t_us();
    plant.inject(PlantFault::WheelBlocked(Wheel::Left));
    plant.advance_to(at_us + 1_000);
    assert!(plant.wheel_speeds_rad_s().left > 2.0);
    plant.advance_to(at_us + 25_000);
    assert_eq!(plant.wheel_speeds_rad_s().left, 0.0);
    // Whatever the motor does, the hand is stronger.
    drive(&mut plant, 1.0, 1.0, 200_000);
    assert_eq!(plant.wheel_speeds_rad_s().left, 0.0);
    plant.remove(PlantFault::WheelBlocked(Wheel::Left));
    drive(&mut plant, 0.3, 0.3, 200_000);
    assert!(plant.wheel_speeds_rad_s().left > 1.0);
}

#[test]
fn a_jam_stops_the_wheel_at_once() {
    let mut plant = cruising();
    plant.inject(PlantFault::WheelJammed(Wheel::Right));
    plant.advance_to(plant.t_us() + 1_000);
    assert_eq!(plant.wheel_speeds_rad_s().right, 0.0);
    assert!(plant.wheel_speeds_rad_s().left > 2.0);
    drive(&mut plant, 0.273, 0.273, 300_000);
    assert!(plant.twist().yaw_rate_rad_s < -0.1, "it turns about the locked wheel");
}

#[test]
fn a_motor_without_a_lead_carries_no_current_and_its_wheel_rolls_on() {
    let mut plant = cruising();
    plant.inject(PlantFault::MotorUnplugged(Wheel::Left));
    drive(&mut plant, 0.273, 0.273, 20_000);
    assert_eq!(plant.currents_a().left, 0.0);
    assert!(plant.currents_a().right > 0.05);
    assert!(plant.wheel_speeds_rad_s().left > 1.0);
}

#[test]
fn swapped_motor_leads_turn_the_wheel_backwards() {
    let mut plant = robot(PlantParameters::default());
    plant.inject(PlantFault::MotorReversed(Wheel::Left));
    drive(&mut plant, 0.3, 0.3, 1_000_000);
    let spin = plant.wheel_speeds_rad_s();
    assert!(spin.left < -2.0 && spin.right > 2.0, "{spin:?}");
    // A parameter says the same for good, and the two cancel.
    let mut parameters = PlantParameters::default();
    parameters.motor.left.reversed = true;
    let mut plant = robot(parameters);
    plant.inject(PlantFault::MotorReversed(Wheel::Left));
    drive(&mut plant, 0.3, 0.3, 1_000_000);
    assert!(plant.wheel_speeds_rad_s().left > 2.0);
}

#[test]
fn a_driver_fault_opens_both_bridges_and_shows_on_its_line() {
    let mut plant = cruising();
    assert!(!plant.driver_fault_line());
    plant.inject(PlantFault::DriverFault);
    plant.advance_to(plant.t_us() + 1_000);
    assert!(plant.driver_fault_line());
    assert_eq!(plant.currents_a().left, 0.0);
    assert_eq!(plant.currents_a().right, 0.0);
    plant.remove(PlantFault::DriverFault);
    plant.advance_to(plant.t_us() + 1_000);
    assert!(!plant.driver_fault_line() && plant.currents_a().left > 0.0);
}

#[test]
fn the_emergency_stop_is_a_line_and_leaves_the_power_to_the_controller() {
    let mut plant = cruising();
    plant.inject(PlantFault::EmergencyStop);
    plant.advance_to(plant.t_us() + 10_000);
    assert!(plant.estop_line());
    assert!(plant.currents_a().left > 0.05);
    plant.remove(PlantFault::EmergencyStop);
    assert!(!plant.estop_line());
}

#[test]
fn a_dip_lowers_the_supply_while_it_lasts() {
    let mut plant = cruising();
    let before_v = plant.bus_v();
    plant.inject(PlantFault::SupplyDip { volts: 4.0 });
    plant.advance_to(plant.t_us() + 500_000);
    assert!((before_v - plant.bus_v() - 4.0).abs() < 0.05, "{}", plant.bus_v());
    plant.remove(PlantFault::SupplyDip { volts: 0.0 });
    plant.advance_to(plant.t_us() + 500_000);
    assert!((before_v - plant.bus_v()).abs() < 0.01);
}

#[test]
fn the_first_drive_is_noted_once() {
    let mut plant = robot(PlantParameters::default());
    plant.advance_to(5_000);
    plant.set_enabled(true);
    assert_eq!(plant.first_driven_us(), None, "no duty yet");
    drive(&mut plant, 0.1, 0.1, 1_000);
    drive(&mut plant, 0.0, 0.0, 1_000);
    drive(&mut plant, 0.1, 0.1, 1_000);
    assert_eq!(plant.first_driven_us(), Some(5_000));
}
