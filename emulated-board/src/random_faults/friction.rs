//! What friction and the configured kS do to a case: how far a soft loop may stay off, and how early a wheel turns.

use shared_proto::{Config, Wheel};
use sim_target::plant::MotorParameters;

use super::draw::Case;

/// What tyres and caster take as well, of up to 4 kg more, on a slope: as a factor of the motor's friction.
const ROLLING: f64 = 1.4;

impl Case {
    /// Whether its gains are not the factory's.
    pub fn has_other_gains(&self) -> bool {
        self.config.as_ref().is_some_and(|config| config.pid != Config::default().pid)
    }

    /// How far off its target friction holds a wheel, at most, where the loop's gain and kS are too low for it \[m\].
    pub fn held_off_m(&self) -> f64 {
        let config = self.config.clone().unwrap_or_default();
        let lacking = |wheel| {
            // A wheel may stand on either side of its target.
            let [forward, backward, ..] = config.feedforward.shares(wheel);
            let ks = forward.min(backward);
            ((ROLLING * self.friction_share(wheel) - ks) / config.pid.kp_per_m).max(0.0)
        };
        lacking(Wheel::Left).max(lacking(Wheel::Right))
    }

    /// So many times what friction takes is the duty that is configured for it, at this supply.
    pub fn ks_times(&self) -> f64 {
        let config = self.config.clone().unwrap_or_default();
        let times = |wheel| config.feedforward.shares(wheel)[0] / self.friction_share(wheel);
        times(Wheel::Left).max(times(Wheel::Right))
    }

    /// How much faster than its setpoint a kS that is too large turns a wheel whose count stands, at most; of the factory's gains
    /// that is in the bounds \[m/s\].
    pub fn creeps_mps(&self) -> f64 {
        let Some(config) = self.config.as_ref().filter(|_| self.has_other_gains()) else {
            return 0.0;
        };
        let creeps = |wheel| {
            let [forward, backward, ..] = config.feedforward.shares(wheel);
            let excess = forward.max(backward) - self.friction_share(wheel);
            let usual_kv = Config::default().feedforward.wheel(wheel).kv_v_s_per_m;
            (excess * self.scenario.plant.supply.open_circuit_v / usual_kv).max(0.0)
        };
        creeps(Wheel::Left).max(creeps(Wheel::Right))
    }

    /// The duty that a wheel's dry friction takes.
    fn friction_share(&self, wheel: Wheel) -> f64 {
        let plant = &self.scenario.plant;
        let motor = match wheel {
            Wheel::Left => &plant.motor.left,
            Wheel::Right => &plant.motor.right,
        };
        let usual_v = Config::default().feedforward.wheel(wheel).ks_forward_v;
        let usual_nm = MotorParameters::default().coulomb_torque_nm;
        usual_v * motor.coulomb_torque_nm / usual_nm / plant.supply.open_circuit_v
    }
}
