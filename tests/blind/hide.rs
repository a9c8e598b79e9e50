//! The effects that can be hidden in a robot.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sim_target::Scenario;

/// The strength at which an effect's detectability is measured first.
pub const REFERENCE: f64 = 1.0;

/// Effects of the catalogue.
pub const INSIDE: &[&str] =
    &["wheel_radius_ratio", "wheel_radius_scale", "track_width", "measurement_delay"];

/// Effects outside the catalogue.
pub const OUTSIDE: &[&str] = &["slippery_floor"];

/// One effect to be hidden.
#[derive(Clone, Copy, Debug)]
pub struct Hidden {
    /// Its id.
    pub id: &'static str,
    /// Its strength; 1 is typical in the field.
    pub strength: f64,
    /// Draws signs and directions.
    pub seed: u64,
}

impl Hidden {
    /// Puts it into the robot or what is round it.
    pub fn hide(&self, scenario: &mut Scenario) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let sign = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        let geometry = &mut scenario.plant.geometry;
        match self.id {
            "wheel_radius_ratio" => {
                let rho = 0.01 * sign * self.strength;
                geometry.wheel_radius_m.left *= 1.0 - rho / 2.0;
                geometry.wheel_radius_m.right *= 1.0 + rho / 2.0;
            }
            "wheel_radius_scale" => {
                geometry.wheel_radius_m =
                    geometry.wheel_radius_m.map(|it| it * (1.0 + 0.005 * sign * self.strength));
            }
            "track_width" => geometry.track_width_m *= 1.0 + 0.02 * sign * self.strength,
            "measurement_delay" => {
                scenario.camera.delay_known = false;
                scenario.camera.delay_s = 0.04 * self.strength;
            }
            "slippery_floor" => scenario.plant.floor.friction = 0.1,
            _ => {}
        }
    }
}

/// What the unexplained part of an effect outside the catalogue depends on, in the words of `explain`.
pub fn regressors(id: &str) -> &'static [&'static str] {
    match id {
        "slippery_floor" => &["acceleration"],
        _ => &[],
    }
}

/// Parameters of an effect as the plant has them, by the names of the model.
pub fn true_parameters(id: &str, scenario: &Scenario) -> Vec<(&'static str, f64)> {
    let share = super::field::radius_shares(scenario);
    let nominal = sim_target::plant::PlantParameters::default().geometry;
    let mean = (share.left + share.right) / 2.0;
    match id {
        "wheel_radius_ratio" => vec![("rho", (share.right - share.left) / mean)],
        "wheel_radius_scale" => vec![("s", mean - 1.0)],
        "track_width" => {
            vec![("delta", scenario.plant.geometry.track_width_m / nominal.track_width_m - 1.0)]
        }
        "measurement_delay" => vec![("tau", scenario.camera.delay_s)],
        _ => Vec::new(),
    }
}
