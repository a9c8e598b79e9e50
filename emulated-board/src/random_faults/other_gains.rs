//! Robots with other gains than the factory's, and another floor.

use std::f64::consts::PI;

use host_link::motion::Motion;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use shared_proto::{Config, FeedforwardConfig, PidConfig};
use sim_target::Scenario;
use sim_target::plant::MotorParameters;

/// Of the loop, compared with the factory's.
const STIFFNESS: (f64, f64) = (0.35, 1.5);
/// Steepest floor \[rad\]; docs/safety.md says what a steeper one does to the encoder check.
const SLOPE_RAD_MAX: f64 = 0.02;

/// Gains as another user has them.
pub(super) struct OtherGains {
    pub pid: PidConfig,
    pub feedforward: FeedforwardConfig,
    pub duty_max: f64,
}

/// Gains, feedforward and largest duty of somebody who tuned another robot, or a softer one; and a floor that slopes a little.
/// By a stream of its own, as the encoders.
pub(super) fn other_gains(
    seed: u64,
    index: u64,
    scenario: &mut Scenario,
    motion: &Motion,
) -> OtherGains {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::MAX / 2 - index);
    let Config { mut pid, mut feedforward, .. } = Config::default();
    let stiffness: f64 = rng.random_range(STIFFNESS.0.ln()..STIFFNESS.1.ln()).exp();
    pid.kp_per_m *= stiffness;
    pid.ki_per_m_s *= stiffness * rng.random_range(0.5..2.0);
    pid.kd_s_per_m *= stiffness;
    let mut needed_v: f64 = 0.0;
    for (wheel, motor) in [
        (&mut feedforward.left, &scenario.plant.motor.left),
        (&mut feedforward.right, &scenario.plant.motor.right),
    ] {
        let usual = *wheel;
        let friction = motor.coulomb_torque_nm / MotorParameters::default().coulomb_torque_nm;
        needed_v = needed_v.max(
            friction * usual.ks_forward_v
                + usual.kv_v_s_per_m * motion.cruise
                + 2.0 * usual.ka_v_s2_per_m * motion.acceleration,
        );
        wheel.ks_forward_v *= rng.random_range(0.3..2.0);
        wheel.ks_backward_v *= rng.random_range(0.3..2.0);
        wheel.kv_v_s_per_m *= rng.random_range(0.85..1.15);
        wheel.ka_v_s2_per_m *= rng.random_range(0.5..1.5);
    }
    scenario.plant.floor.slope_rad = rng.random_range(0.0..SLOPE_RAD_MAX);
    scenario.plant.floor.downhill_rad = rng.random_range(-PI..PI);
    // A robot that can drive as it is told, with a little to spare.
    let least = (1.3 * needed_v / scenario.plant.supply.open_circuit_v).min(0.99);
    OtherGains { pid, feedforward, duty_max: rng.random_range(least..1.0) }
}
