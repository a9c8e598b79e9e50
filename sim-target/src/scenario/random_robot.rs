//! Random robots, for a benchmark.

use core::f64::consts::FRAC_PI_2;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{PlacementParameters, Scenario};
use crate::plant::MotorParameters;

impl Scenario {
    /// A random robot similar to the paper's. The same seed gives the same robot.
    ///
    /// | what | drawn from |
    /// | --- | --- |
    /// | wheel ratio R_R/R_L | 0.985 to 1.015 |
    /// | both radii | +-0.3 % |
    /// | track | +-0.5 % |
    /// | mass, inertia, each motor's constants and friction, tyre stiffness and grip, caster friction | +-10 % |
    /// | centre of mass | +-1 cm forward, +-0.5 cm aside |
    /// | caster at the start | within 0.3 rad of trailing in three of four robots, else within pi/2 |
    /// | start heading | sigma 2 mrad |
    /// | encoder phases | anywhere |
    pub fn draw(seed: u64) -> Scenario {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut within = |half_width: f64| rng.random_range(-half_width..=half_width);
        let mut scenario = Scenario { name: format!("drawn {seed}"), seed, ..Scenario::default() };
        let plant = &mut scenario.plant;

        let ratio = 1.0 + within(0.015);
        let radius_m = 0.036 * (1.0 + within(0.003));
        plant.geometry.wheel_radius_m.left = radius_m;
        plant.geometry.wheel_radius_m.right = radius_m * ratio;
        plant.geometry.track_width_m = 0.372 * (1.0 + within(0.005));

        let mut vary = |value: &mut f64| *value *= 1.0 + within(0.1);
        vary(&mut plant.body.mass_kg);
        vary(&mut plant.body.yaw_inertia_kgm2);
        let mut vary_motor = |motor: &mut MotorParameters| {
            vary(&mut motor.resistance_ohm);
            vary(&mut motor.torque_constant_nm_per_a);
            vary(&mut motor.rotor_inertia_kgm2);
            vary(&mut motor.coulomb_torque_nm);
            vary(&mut motor.viscous_torque_nms);
        };
        vary_motor(&mut plant.motor.left);
        vary_motor(&mut plant.motor.right);
        vary(&mut plant.tyre.longitudinal_stiffness_n_per_m);
        vary(&mut plant.tyre.lateral_stiffness_n_per_m);
        vary(&mut plant.tyre.rolling_resistance);
        vary(&mut plant.floor.friction);
        vary(&mut plant.caster.swivel_friction_nm);
        vary(&mut plant.caster.rolling_resistance);

        plant.body.center_of_mass_forward_m += within(0.01);
        plant.body.center_of_mass_left_m += within(0.005);
        let kicks = within(1.0) > 0.5;
        plant.caster.start_angle_rad = within(if kicks { FRAC_PI_2 } else { 0.3 });
        plant.encoder.left.phase = None;
        plant.encoder.right.phase = None;
        scenario.placement = PlacementParameters { heading_sigma_rad: 0.002, ..scenario.placement };
        scenario
    }
}
