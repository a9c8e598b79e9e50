//! Pictures that a camera drops without notice.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::camera_sample::CameraSample;
use crate::plant::{ParameterError, RangeCheck};

/// Dropped pictures. In their place comes the last one again, under a fresh stamp.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StaleParameters {
    /// Share of pictures with which a drop begins.
    pub share: f64,
    /// How many pictures a drop lasts.
    pub pictures: u32,
}

impl Default for StaleParameters {
    fn default() -> Self {
        Self { share: 0.0, pictures: 3 }
    }
}

impl StaleParameters {
    pub(super) fn validate(&self) -> Result<(), ParameterError> {
        let check = RangeCheck("stale.");
        check.within("share", self.share, 0.0, 0.5)?;
        check.within("pictures", self.pictures.into(), 1.0, 1000.0)
    }
}

/// Decides which pictures are dropped, with a random stream of its own.
#[derive(Clone, Debug)]
pub(super) struct Stale {
    parameters: StaleParameters,
    rng: ChaCha8Rng,
    left: u32,
    last: Option<CameraSample>,
}

impl Stale {
    pub fn new(parameters: StaleParameters, seed: u64) -> Self {
        Self { parameters, rng: numbers(seed, 0), left: 0, last: None }
    }

    /// Begins afresh, with the drops of the n-th recording.
    pub fn restart(&mut self, seed: u64, recording: u64) {
        *self = Self { rng: numbers(seed, recording), ..Self::new(self.parameters, seed) };
    }

    /// The sample that arrives when this one should.
    pub fn pass(&mut self, sample: CameraSample) -> CameraSample {
        if self.parameters.share == 0.0 {
            return sample;
        }
        if self.left == 0 && self.rng.random::<f64>() < self.parameters.share {
            self.left = self.parameters.pictures;
        }
        match self.last {
            Some(last) if self.left > 0 => {
                self.left -= 1;
                CameraSample { t_s: sample.t_s, ..last }
            }
            _ => {
                self.last = Some(sample);
                sample
            }
        }
    }
}

/// Numbers of the n-th recording; the camera's noise takes the streams from 0 on.
fn numbers(seed: u64, recording: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::MAX - recording);
    rng
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(i: u32) -> CameraSample {
        CameraSample { t_s: f64::from(i), x_m: f64::from(i), y_m: 0.0, heading_rad: 0.0 }
    }

    #[test]
    fn drops_repeat_the_last_picture_under_a_fresh_stamp_as_often_as_declared() {
        let mut stale = Stale::new(StaleParameters { share: 0.05, pictures: 3 }, 4);
        let seen: Vec<_> = (0..20_000).map(|i| stale.pass(sample(i))).collect();
        assert!(seen.iter().enumerate().all(|(i, s)| s.t_s == i as f64));
        let late: Vec<f64> = seen.iter().map(|s| s.t_s - s.x_m).collect();
        let share = late.iter().filter(|&&lag| lag > 0.0).count() as f64 / 20_000.0;
        // Three in every 3 + 19 pictures; 870 drops give 3.4 % of sampling error, 4 of these.
        assert!((share / (3.0 / 22.0) - 1.0).abs() < 0.14, "{share}");
        assert!(late.iter().all(|&lag| lag >= 0.0));
    }

    #[test]
    fn a_camera_that_drops_nothing_passes_everything() {
        let mut stale = Stale::new(StaleParameters::default(), 4);
        assert!((0..100).all(|i| stale.pass(sample(i)) == sample(i)));
    }
}
