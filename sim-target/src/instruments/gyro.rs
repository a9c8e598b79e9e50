//! A yaw rate sensor on the robot.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use crate::plant::{ParameterError, Plant, RangeCheck};

/// How good the gyro is.
///
/// ```text
/// reading = (1 + s) omega + bias + noise          (1)
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GyroParameters {
    /// Readings per second \[Hz\].
    pub rate_hz: f64,
    /// Reading at rest \[rad/s\].
    pub bias_rad_s: f64,
    /// Error of its scale, s: 0.01 reads a hundredth too much.
    pub scale: f64,
    /// Noise of one reading, standard deviation \[rad/s\].
    pub sigma_rad_s: f64,
}

impl Default for GyroParameters {
    /// A phone's chip, well calibrated.
    fn default() -> Self {
        Self { rate_hz: 100.0, bias_rad_s: 0.0, scale: 0.0, sigma_rad_s: 0.002 }
    }
}

impl GyroParameters {
    /// Refuses a value outside its range, and names the field.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let check = RangeCheck("");
        check.within("rate_hz", self.rate_hz, 0.1, 2000.0)?;
        check.within("bias_rad_s", self.bias_rad_s, -1.0, 1.0)?;
        check.within("scale", self.scale, -0.5, 0.5)?;
        check.within("sigma_rad_s", self.sigma_rad_s, 0.0, 1.0)
    }
}

/// A reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroSample {
    /// When \[s\].
    pub t_s: f64,
    /// Counter-clockwise positive \[rad/s\].
    pub yaw_rate_rad_s: f64,
}

/// The gyro, and its next reading.
#[derive(Clone, Debug)]
pub struct Gyro {
    parameters: GyroParameters,
    rng: ChaCha8Rng,
    readings: u64,
}

impl Gyro {
    /// A gyro that is read for the first time at time zero.
    pub fn new(parameters: GyroParameters, seed: u64) -> Self {
        Self { parameters, rng: ChaCha8Rng::seed_from_u64(seed), readings: 0 }
    }

    /// When the next reading is due \[us\].
    pub fn next_t_us(&self) -> u64 {
        (self.readings as f64 * 1e6 / self.parameters.rate_hz).round() as u64
    }

    /// Reads the plant's yaw rate if a reading is due; a late call skips the missed readings.
    pub fn observe(&mut self, plant: &Plant) -> Option<GyroSample> {
        let t_us = plant.t_us();
        (t_us >= self.next_t_us()).then(|| self.read(t_us, plant.twist().yaw_rate_rad_s))
    }

    /// Reads a yaw rate at a time (1).
    pub fn read(&mut self, t_us: u64, yaw_rate_rad_s: f64) -> GyroSample {
        while self.next_t_us() <= t_us {
            self.readings += 1;
        }
        let noise: f64 = StandardNormal.sample(&mut self.rng);
        let GyroParameters { bias_rad_s, scale, sigma_rad_s, .. } = self.parameters;
        GyroSample {
            t_s: t_us as f64 * 1e-6,
            yaw_rate_rad_s: (1.0 + scale) * yaw_rate_rad_s + bias_rad_s + sigma_rad_s * noise,
        }
    }

    /// The gyro's parameters.
    pub fn parameters(&self) -> &GyroParameters {
        &self.parameters
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bias_shows_at_rest_and_scale_in_a_turn() {
        let parameters =
            GyroParameters { bias_rad_s: 0.02, scale: -0.03, ..GyroParameters::default() };
        let mut gyro = Gyro::new(parameters, 3);
        let n = 10_000;
        let mut mean = |omega: f64, first: u64| {
            (0..n).map(|i| gyro.read((first + i) * 10_000, omega).yaw_rate_rad_s).sum::<f64>()
                / n as f64
        };
        // Sampling error of the mean: 2e-5; 4 of these.
        assert!((mean(0.0, 0) - 0.02).abs() < 8e-5);
        assert!((mean(1.5, n) - (0.97 * 1.5 + 0.02)).abs() < 8e-5);
    }

    #[test]
    fn a_perfect_gyro_reads_the_plants_yaw_rate_at_its_rate() {
        let parameters =
            GyroParameters { sigma_rad_s: 0.0, rate_hz: 250.0, ..GyroParameters::default() };
        let mut gyro = Gyro::new(parameters, 3);
        let mut plant = Plant::new(Default::default(), Default::default(), 1);
        plant.set_enabled(true);
        plant.set_duty(shared_proto::WheelPair::new(0.2, 0.4));
        for reading in 0..100 {
            plant.advance_to(gyro.next_t_us());
            let sample = gyro.observe(&plant).expect("one is due");
            assert_eq!(sample.yaw_rate_rad_s, plant.twist().yaw_rate_rad_s);
            assert!((sample.t_s - f64::from(reading) * 0.004).abs() < 1e-12);
            assert_eq!(gyro.observe(&plant), None);
        }
    }
}
