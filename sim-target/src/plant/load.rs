//! Distribution of the weight over the three wheels.

use shared_proto::WheelPair;

use super::parameters::PlantParameters;

/// The floor's upward force on each wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loads {
    /// On the driven wheels \[N\].
    pub driven_n: WheelPair<f64>,
    /// On the caster \[N\].
    pub caster_n: f64,
}

/// Balance of moments about the axle and about the midline, for a body that accelerates by (a_x, a_y):
///
/// ```text
/// N_C        = m (-g c_x + a_x h) / l             (1)  l: caster's pivot behind the axle
/// N_L + N_R  = m g - N_C                          (2)
/// N_L - N_R  = 2 m (g c_y - a_y h) / b            (3)
/// ```
///
/// Accelerating puts load on the caster, a left turn puts load on the right wheel. A wheel that
/// would lift carries nothing: the body does not tip over here.
#[derive(Clone, Copy, Debug)]
pub(super) struct LoadModel {
    weight_n: f64,
    caster_at_rest_n: f64,
    caster_per_forward: f64,
    difference_at_rest_n: f64,
    difference_per_left: f64,
}

impl LoadModel {
    /// The robot with its payload.
    pub fn new(parameters: &PlantParameters) -> Self {
        Self::of_mass(parameters, parameters.body.laden_mass_kg())
    }

    /// The robot without its payload.
    pub fn unladen(parameters: &PlantParameters) -> Self {
        Self::of_mass(parameters, parameters.body.mass_kg)
    }

    fn of_mass(parameters: &PlantParameters, mass_kg: f64) -> Self {
        let body = &parameters.body;
        let weight_n = mass_kg * parameters.floor.gravity_mps2;
        let moment_kgm = mass_kg * body.center_of_mass_height_m;
        let to_caster = 1.0 / parameters.caster.pivot_behind_m;
        let to_wheels = 2.0 / parameters.geometry.track_width_m;
        Self {
            weight_n,
            caster_at_rest_n: -weight_n * body.center_of_mass_forward_m * to_caster,
            caster_per_forward: moment_kgm * to_caster,
            difference_at_rest_n: weight_n * body.center_of_mass_left_m * to_wheels,
            difference_per_left: -moment_kgm * to_wheels,
        }
    }

    #[inline]
    pub fn loads(&self, (forward_mps2, left_mps2): (f64, f64)) -> Loads {
        let caster_n = self.caster_at_rest_n + self.caster_per_forward * forward_mps2; // (1)
        let sum_n = self.weight_n - caster_n; // (2)
        let difference_n = self.difference_at_rest_n + self.difference_per_left * left_mps2; // (3)
        Loads {
            driven_n: WheelPair {
                left: (0.5 * (sum_n + difference_n)).max(0.0),
                right: (0.5 * (sum_n - difference_n)).max(0.0),
            },
            caster_n: caster_n.max(0.0),
        }
    }
}
