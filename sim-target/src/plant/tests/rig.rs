//! What drives a plant in these tests: the paper's profile, with or without a loop round it.

use core::f64::consts::TAU;

use shared_proto::WheelPair;

use crate::plant::{Plant, PlantParameters, Pose};

/// A robot at the origin.
pub fn robot(parameters: PlantParameters) -> Plant {
    Plant::new(parameters, Pose::default(), 1)
}

/// The standard robot with what resists its motion taken away: no friction but that of the tyres' grip.
pub fn frictionless() -> PlantParameters {
    let mut parameters = PlantParameters::default();
    for motor in [&mut parameters.motor.left, &mut parameters.motor.right] {
        (motor.coulomb_torque_nm, motor.viscous_torque_nms) = (0.0, 0.0);
    }
    parameters.tyre.rolling_resistance = 0.0;
    parameters.caster.rolling_resistance = 0.0;
    parameters.caster.swivel_friction_nm = 0.0;
    parameters
}

/// Wheel turns, turns/s and turns/s^2 at a time of the paper's run: 0.101, 0.523, 8 turns.
fn paper_profile(t_s: f64) -> (f64, f64, f64) {
    let (a, v, d) = (0.101, 0.523, 8.0);
    let ramp_s = v / a;
    let end_s = d / v + ramp_s;
    if t_s < ramp_s {
        (0.5 * a * t_s * t_s, a * t_s, a)
    } else if t_s < end_s - ramp_s {
        (v * (t_s - 0.5 * ramp_s), v, 0.0)
    } else if t_s < end_s {
        let left_s = end_s - t_s;
        (d - 0.5 * a * left_s * left_s, a * left_s, -a)
    } else {
        (d, 0.0, 0.0)
    }
}

/// Drives the paper's run, each wheel's share of it by `direction`, and lets the robot come to rest.
///
/// Feedforward for the standard robot; `gain` is the feedback, in duty per radian of wheel angle.
pub fn drive_paper_run(plant: &mut Plant, direction: WheelPair<f64>, gain: f64) {
    let begin = plant.wheel_angles_rad();
    let begin_us = plant.t_us();
    plant.set_enabled(true);
    for ms in 0..22_000_u64 {
        let t_s = ms as f64 * 1e-3;
        let (turns, speed, acceleration) = paper_profile(t_s);
        let angles = plant.wheel_angles_rad().zip(begin).map(|(now, begin)| now - begin);
        let duty = angles.zip(direction).map(|(angle_rad, direction)| {
            let (angle, w, dw) = (turns * TAU, speed * TAU, acceleration * TAU);
            let friction = if speed > 0.0 { 0.04 } else { 0.0 };
            let feedforward = friction + 0.0712 * w + 0.0023 * dw;
            let hold = if t_s > 21.0 { 0.0 } else { gain };
            direction * feedforward + hold * (direction * angle - angle_rad)
        });
        plant.set_duty(duty);
        plant.advance_to(begin_us + (ms + 1) * 1000);
    }
}

/// Drives with a fixed duty for a while.
pub fn drive(plant: &mut Plant, left: f64, right: f64, duration_us: u64) {
    plant.set_enabled(true);
    plant.set_duty(WheelPair::new(left, right));
    plant.advance_to(plant.t_us() + duration_us);
}
