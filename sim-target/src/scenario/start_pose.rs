//! How precisely the robot is put on the start line.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use crate::plant::{ParameterError, Pose, RangeCheck};

/// The errors of placing the robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlacementParameters {
    /// Heading error, standard deviation \[rad\].
    pub heading_sigma_rad: f64,
    /// Position error along and across the line, standard deviation of each \[m\].
    pub position_sigma_m: f64,
    /// True if the robot is rolled forward onto its mark, so that its caster trails. Otherwise the caster
    /// keeps its angle.
    pub caster_trails: bool,
}

impl Default for PlacementParameters {
    /// By eye along a line on the floor: 0.5 mrad is 0.2 mm between the wheels.
    fn default() -> Self {
        Self { heading_sigma_rad: 0.0005, position_sigma_m: 0.0, caster_trails: false }
    }
}

impl PlacementParameters {
    /// Refuses a value outside its range, and names the field.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let check = RangeCheck("");
        check.within("heading_sigma_rad", self.heading_sigma_rad, 0.0, 1.0)?;
        check.within("position_sigma_m", self.position_sigma_m, 0.0, 1.0)
    }

    /// Puts the robot on a line, for the `run`-th time.
    pub fn place(&self, line: Pose, seed: u64, run: u64) -> Pose {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(run);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        line.then(Pose {
            x_m: self.position_sigma_m * normal(),
            y_m: self.position_sigma_m * normal(),
            heading_rad: self.heading_sigma_rad * normal(),
        })
    }
}
