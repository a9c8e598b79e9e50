//! An overhead camera that tracks a marker on the robot.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

use super::camera_sample::CameraSample;
use super::dropped_pictures::{Stale, StaleParameters};
use super::lens::{LensParameters, MarkerParameters};
use crate::plant::{ParameterError, Plant, Pose, RangeCheck};

/// How good the camera is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraParameters {
    /// Pictures per second \[Hz\].
    pub rate_hz: f64,
    /// Noise of x and of y, standard deviation \[m\].
    pub position_sigma_m: f64,
    /// Noise of the heading, standard deviation \[rad\].
    pub heading_sigma_rad: f64,
    /// From exposure to the pose's arrival \[s\].
    pub delay_s: f64,
    /// True if the camera stamps the exposure, because its delay is known; otherwise the arrival.
    pub delay_known: bool,
    /// Where the marker is; on the axle's midpoint by default.
    pub marker: MarkerParameters,
    /// The lens; without distortion by default.
    pub lens: LensParameters,
    /// Dropped pictures.
    pub stale: StaleParameters,
}

impl Default for CameraParameters {
    /// A webcam under the ceiling and a printed marker: 1 mm, 2 mrad.
    fn default() -> Self {
        Self {
            rate_hz: 30.0,
            position_sigma_m: 0.001,
            heading_sigma_rad: 0.002,
            delay_s: 0.04,
            delay_known: true,
            marker: MarkerParameters::default(),
            lens: LensParameters::default(),
            stale: StaleParameters::default(),
        }
    }
}

impl CameraParameters {
    /// Refuses a value outside its range, and names the field.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let check = RangeCheck("");
        check.within("rate_hz", self.rate_hz, 0.1, 1000.0)?;
        check.within("position_sigma_m", self.position_sigma_m, 0.0, 1.0)?;
        check.within("heading_sigma_rad", self.heading_sigma_rad, 0.0, 1.0)?;
        check.within("delay_s", self.delay_s, 0.0, 2.0)?;
        self.marker.validate()?;
        self.lens.validate()?;
        self.stale.validate()
    }
}

/// The camera, and its next picture.
#[derive(Clone, Debug)]
pub struct Camera {
    parameters: CameraParameters,
    seed: u64,
    rng: ChaCha8Rng,
    /// Of the first picture \[us\].
    origin_us: u64,
    pictures: u64,
    triggers: u64,
    stale: Stale,
}

impl Camera {
    /// A camera that takes its first picture at time zero.
    pub fn new(parameters: CameraParameters, seed: u64) -> Self {
        let rng = ChaCha8Rng::seed_from_u64(seed);
        let stale = Stale::new(parameters.stale, seed);
        Self { parameters, seed, rng, origin_us: 0, pictures: 0, triggers: 0, stale }
    }

    /// Takes the next picture at this time, and further ones at the camera's rate.
    ///
    /// Noise and dropped pictures depend only on the seed and on how many triggers came before, not on when
    /// a recording begins.
    pub fn trigger(&mut self, t_us: u64) {
        self.triggers += 1;
        self.rng = ChaCha8Rng::seed_from_u64(self.seed);
        self.rng.set_stream(self.triggers);
        self.stale.restart(self.seed, self.triggers);
        self.origin_us = t_us;
        self.pictures = 0;
    }

    /// When the next picture is due \[us\].
    pub fn next_t_us(&self) -> u64 {
        self.origin_us + (self.pictures as f64 * 1e6 / self.parameters.rate_hz).round() as u64
    }

    /// Takes a picture of the robot if one is due, and sets the time of the next one.
    ///
    /// Call this when the plant is at [`next_t_us`](Self::next_t_us). A late call gets a picture of its own
    /// moment; missed pictures are not made up for.
    pub fn observe(&mut self, plant: &Plant) -> Option<CameraSample> {
        (plant.t_us() >= self.next_t_us()).then(|| self.expose(plant.t_us(), plant.pose()))
    }

    /// Measures a pose at a time.
    pub fn expose(&mut self, t_us: u64, pose: Pose) -> CameraSample {
        while self.next_t_us() <= t_us {
            self.pictures += 1;
        }
        let exposed_s = t_us as f64 * 1e-6;
        let lateness_s = if self.parameters.delay_known { 0.0 } else { self.parameters.delay_s };
        let CameraParameters { position_sigma_m, heading_sigma_rad, .. } = self.parameters;
        let pose = self.parameters.lens.bend(self.parameters.marker.seen_on(pose));
        let sample = CameraSample {
            t_s: exposed_s + lateness_s,
            x_m: pose.x_m + position_sigma_m * self.normal(),
            y_m: pose.y_m + position_sigma_m * self.normal(),
            heading_rad: pose.heading_rad + heading_sigma_rad * self.normal(),
        };
        self.stale.pass(sample)
    }

    /// The camera's parameters.
    pub fn parameters(&self) -> &CameraParameters {
        &self.parameters
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.rng)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSE: Pose = Pose { x_m: 1.5, y_m: -0.25, heading_rad: 7.0 };

    #[test]
    fn pictures_come_at_the_rate_however_long_the_run() {
        let mut camera =
            Camera::new(CameraParameters { rate_hz: 30.0, ..CameraParameters::default() }, 1);
        for picture in 0..3000_u64 {
            let due_us = camera.next_t_us();
            // 1/30 s is no whole number of microseconds: the rounding must not add up.
            assert!(due_us.abs_diff(picture * 100_000 / 3) <= 1, "picture {picture} at {due_us}");
            camera.expose(due_us, POSE);
        }
    }

    #[test]
    fn a_late_call_skips_the_pictures_that_were_missed() {
        let mut camera =
            Camera::new(CameraParameters { rate_hz: 10.0, ..CameraParameters::default() }, 1);
        camera.expose(250_000, POSE);
        assert_eq!(camera.next_t_us(), 300_000);
    }

    #[test]
    fn a_trigger_makes_the_same_recording_whenever_it_comes() {
        let record = |before: u64, t_us: u64| -> Vec<_> {
            let mut camera = Camera::new(CameraParameters::default(), 5);
            for _ in 0..before {
                camera.expose(camera.next_t_us(), POSE);
            }
            camera.trigger(t_us);
            let pictures = (0..100).map(|_| {
                let due_us = camera.next_t_us();
                let sample = camera.expose(due_us, POSE);
                (due_us - t_us, sample.x_m, sample.y_m, sample.heading_rad)
            });
            pictures.collect()
        };
        assert_eq!(record(0, 10_000_000), record(17, 12_345_678));
    }

    #[test]
    fn an_unknown_delay_makes_the_stamp_late_and_a_known_one_does_not() {
        for (delay_known, stamp_s) in [(false, 1.04), (true, 1.0)] {
            let parameters = CameraParameters { delay_known, ..CameraParameters::default() };
            let sample = Camera::new(parameters, 1).expose(1_000_000, POSE);
            assert!((sample.t_s - stamp_s).abs() < 1e-12, "{}", sample.t_s);
        }
    }

    #[test]
    fn the_noise_is_as_large_as_declared_and_has_no_bias() {
        let mut camera = Camera::new(CameraParameters::default(), 7);
        let n = 20_000;
        let samples: Vec<_> = (0..n).map(|i| camera.expose(i * 33_334, POSE)).collect();
        let spread = |residual: &dyn Fn(&CameraSample) -> f64| {
            let mean = samples.iter().map(residual).sum::<f64>() / n as f64;
            let square = samples.iter().map(|s| residual(s).powi(2)).sum::<f64>() / n as f64;
            (mean, square.sqrt())
        };
        // Sampling error at n = 20000: 0.7 % for the mean, 0.5 % for the spread, of sigma; 4 of these.
        for (residual, sigma) in [
            (&(|s: &CameraSample| s.x_m - POSE.x_m) as &dyn Fn(&CameraSample) -> f64, 0.001),
            (&|s: &CameraSample| s.y_m - POSE.y_m, 0.001),
            (&|s: &CameraSample| s.heading_rad - POSE.heading_rad, 0.002),
        ] {
            let (mean, rms) = spread(residual);
            assert!(mean.abs() < 0.03 * sigma, "mean {mean} for sigma {sigma}");
            assert!((rms / sigma - 1.0).abs() < 0.02, "rms {rms} for sigma {sigma}");
        }
    }

    #[test]
    fn a_camera_without_noise_tells_the_truth() {
        let parameters = CameraParameters {
            position_sigma_m: 0.0,
            heading_sigma_rad: 0.0,
            ..CameraParameters::default()
        };
        let sample = Camera::new(parameters, 1).expose(0, POSE);
        assert_eq!((sample.x_m, sample.y_m, sample.heading_rad), (1.5, -0.25, 7.0));
    }
}
