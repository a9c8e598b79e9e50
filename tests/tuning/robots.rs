//! Robots over two decades of motor size, from micro gear motors to scooter hubs.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared_proto::{Config, EncoderConfig, WheelPair};
use sim_target::Scenario;
use sim_target::plant::PlantParameters;

/// A drawn robot, and what its owner knows of it: radius, track width and counts.
pub struct UntunedRobot {
    /// The robot in its world.
    pub scenario: Scenario,
    /// The factory configuration with those three.
    pub config: Config,
    /// kS, kV, kA straight on of the left wheel \[V, V s/m, V s^2/m\], from the drawn parameters.
    pub truth: [f64; 3],
}

/// Draws a robot.
///
/// | what | from | to |
/// | --- | --- | --- |
/// | mass | 0.2 kg | 20 kg, logarithmically |
/// | wheel radius | 13 mm | 85 mm, with the mass |
/// | free speed at 12 V | 0.15 m/s | 1.2 m/s |
/// | stall force of both wheels | 0.5 | 2 times the weight |
/// | dry friction | 2 % | 35 % of the stall torque |
/// | rotor at the wheel | 0.1 | 2 times the inertia of the mass |
/// | counts per turn of a wheel | 12 | 20,000, logarithmically |
/// | delay | 0 | 5 ms |
/// | sag at stall | 0 | 15 % |
/// | play of the gear, in a third | 0.1 | 3 degrees |
pub fn draw(seed: u64) -> UntunedRobot {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x7E57_0000);
    let mut scenario = Scenario { name: format!("untuned {seed}"), seed, ..Scenario::default() };
    let plant = &mut scenario.plant;
    build_body(plant, logarithmic(&mut rng, 0.2, 20.0));
    build_motors(plant, &mut rng);
    let counts = logarithmic(&mut rng, 12.0, 20_000.0).round();
    plant.encoder.left.counts_per_rev = counts;
    plant.encoder.right.counts_per_rev = counts;
    // The stiffest vibration of the drawn robot decides the step of the integration.
    for substep_us in [500, 400, 300, 200, 150, 100, 60, 30, 10] {
        plant.substep_us = substep_us;
        if plant.validate().is_ok() {
            break;
        }
    }
    let mut config = Config::default();
    config.geometry.wheel_radius_m = plant.geometry.wheel_radius_m.left;
    config.geometry.track_width_m = plant.geometry.track_width_m;
    let encoder = EncoderConfig { counts_per_rev: counts, gear_reduction: 1.0, reversed: false };
    config.encoder = WheelPair::both(encoder);
    let truth = constants(plant);
    UntunedRobot { scenario, config, truth }
}

fn logarithmic(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    rng.random_range(low.ln()..=high.ln()).exp()
}

/// A body of this mass \[kg\]. Everything that carries grows with it, so that tyres stay as stiff for their load.
fn build_body(plant: &mut PlantParameters, mass_kg: f64) {
    let scale = mass_kg / plant.body.mass_kg;
    let length = scale.powf(0.4);
    plant.body.mass_kg = mass_kg;
    plant.body.yaw_inertia_kgm2 *= scale * length * length;
    plant.body.center_of_mass_forward_m *= length;
    plant.body.center_of_mass_height_m *= length;
    plant.geometry.wheel_radius_m = WheelPair::both(0.036 * length);
    plant.geometry.track_width_m *= length;
    plant.geometry.wheel_inertia_kgm2 *= scale * length * length;
    plant.tyre.longitudinal_stiffness_n_per_m *= scale;
    plant.tyre.lateral_stiffness_n_per_m *= scale;
    plant.tyre.relaxation_length_m *= length;
    plant.tyre.damping_ns_per_m *= scale;
    let caster = &mut plant.caster;
    caster.pivot_behind_m *= length;
    caster.trail_m *= length;
    caster.swivel_inertia_kgm2 = (caster.swivel_inertia_kgm2 * scale * length * length).max(1e-7);
    caster.swivel_friction_nm *= scale * length;
    caster.lateral_stiffness_n_per_m *= scale;
    caster.damping_ns_per_m *= scale;
    caster.relaxation_length_m *= length;
}

/// Motors, gears, driver and battery for that body.
fn build_motors(plant: &mut PlantParameters, rng: &mut ChaCha8Rng) {
    let (mass_kg, radius_m) = (plant.body.mass_kg, plant.geometry.wheel_radius_m.left);
    let free_mps = logarithmic(rng, 0.15, 1.2);
    let stall_n = logarithmic(rng, 0.5, 2.0) * mass_kg * 9.81 / 2.0;
    let friction_share = logarithmic(rng, 0.02, 0.35);
    let rotor_share = logarithmic(rng, 0.1, 2.0);
    let wheel_k = 12.0 / (free_mps / radius_m);
    let stall_nm = stall_n * radius_m;
    let mut motor = plant.motor.left;
    motor.torque_constant_nm_per_a = wheel_k / motor.gear_ratio;
    motor.resistance_ohm = (wheel_k * 12.0 / stall_nm).min(1000.0);
    motor.coulomb_torque_nm = friction_share * stall_nm;
    motor.viscous_torque_nms = 0.01 * wheel_k * wheel_k / motor.resistance_ohm;
    motor.rotor_inertia_kgm2 =
        rotor_share * 0.5 * mass_kg * radius_m * radius_m / motor.gear_ratio.powi(2);
    plant.motor = WheelPair::both(motor);
    // The other motor is never quite the same.
    plant.motor.right.coulomb_torque_nm *= rng.random_range(0.85..=1.15);
    plant.motor.right.torque_constant_nm_per_a *= rng.random_range(0.97..=1.03);

    let sag = rng.random_range(0.0..=0.15);
    let stall_a = 12.0 / motor.resistance_ohm;
    plant.supply.resistance_ohm = (sag * 12.0 / (2.0 * stall_a)).min(10.0);
    plant.supply.standby_current_a = plant.supply.standby_current_a.min(0.05 * stall_a);
    plant.bridge.delay_ms = rng.random_range(0..=5);
    if rng.random_range(0..3) == 0 {
        let play_rad = logarithmic(rng, 0.1, 3.0).to_radians();
        plant.gear.left.backlash_rad = play_rad;
        plant.gear.right.backlash_rad = play_rad;
    }
}

/// kS, kV, kA straight on of the left wheel, from its parts.
pub fn constants(plant: &PlantParameters) -> [f64; 3] {
    let (motor, radius_m) = (&plant.motor.left, plant.geometry.wheel_radius_m.left);
    let k = motor.wheel_torque_constant_nm_per_a();
    let volts_per_nm = motor.resistance_ohm / k;
    let weight_n = plant.body.mass_kg * 9.81;
    let to_caster = -plant.body.center_of_mass_forward_m / plant.caster.pivot_behind_m;
    let caster_n = weight_n * to_caster * plant.caster.rolling_resistance;
    let wheel_n = 0.5 * weight_n * (1.0 - to_caster) * plant.tyre.rolling_resistance;
    let friction_nm = motor.coulomb_torque_nm + radius_m * (wheel_n + 0.5 * caster_n);
    let inertia = plant.geometry.wheel_inertia_kgm2
        + motor.rotor_inertia_kgm2 * motor.gear_ratio.powi(2)
        + 0.5 * plant.body.mass_kg * radius_m * radius_m;
    [
        friction_nm * volts_per_nm,
        (k + motor.viscous_torque_nms * volts_per_nm) / radius_m,
        inertia * volts_per_nm / radius_m,
    ]
}

impl UntunedRobot {
    /// Distance that a wheel rolls per count \[m\].
    pub fn meters_per_count(&self) -> f64 {
        TAU * self.config.geometry.wheel_radius_m / self.config.encoder.left.counts_per_rev
    }
}
