//! How noisy are the measured poses, and how fast does the error of dead reckoning grow?
//!
//! ```text
//! measured = pose + e + white noise                                                   (1)
//! var(growth of the pose's error along d metres) = k^2 d                              (2)
//! e: stationary, exp(-t/T) correlated                                                 (3)
//! heading measured = heading + psi,  time measured = time + tau + delta u, of each run   (4)
//! ```
//!
//! (3) is coloured noise, which makes neighbouring measurements err alike without growing along the path: jitter of
//! the time stamps, a camera that is off in one place, counts that stand still. Without it, the random walk (2) of
//! real recordings comes out too large, and the information of long paths is lost.
//!
//! (4) is constant in a run and different in the next: a body frame that was drawn anew, a clock that was
//! synchronised anew at the beginning and at the end of the run. u goes from -1 at its first pose to 1 at its last, and delta
//! has the spread of tau: errors of both ends that are as large and independent have such a mean and difference.
//! In a run of seconds such a clock is off by a percent, and so would be the track width, as turns in motion look slower than from
//! rest to rest. Only its spread from run to run is noise; what all runs share is an effect.
//!
//! How large each of these is, is estimated in [`crate::estimation`].

use serde::{Deserialize, Serialize};

/// Noise of measured poses, and of the odometry between them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OdometryNoise {
    /// Each coordinate of a measured position, one sigma \[m\].
    pub position_sigma_m: f64,
    /// A measured heading, one sigma \[rad\].
    pub heading_sigma_rad: f64,
    /// Random walk of the position, k_s: sigma after one metre of rolling \[m/sqrt(m)\].
    pub travel_walk: f64,
    /// Random walk of the heading, k_theta: sigma after one metre of rolling \[rad/sqrt(m)\].
    pub heading_walk: f64,
    /// Of (3), each coordinate of the position, one sigma \[m\].
    pub position_wobble_m: f64,
    /// Of (3), the heading, one sigma \[rad\].
    pub heading_wobble_rad: f64,
    /// T of (3) \[s\].
    pub wobble_s: f64,
    /// Random walk of the heading by the yaw rate sensor: sigma after one second \[rad/sqrt(s)\].
    pub gyro_walk: f64,
    /// psi of (4), one sigma over the runs \[rad\].
    pub heading_offset_rad: f64,
    /// tau and delta of (4), one sigma over the runs \[s\].
    pub clock_offset_s: f64,
}

impl OdometryNoise {
    /// Typical values, the centre of the prior: a camera of a millimetre over a hard floor.
    pub const TYPICAL: Self = Self {
        position_sigma_m: 1.5e-3,
        heading_sigma_rad: 2e-3,
        travel_walk: 1e-3,
        heading_walk: 2e-3,
        position_wobble_m: 5e-4,
        heading_wobble_rad: 7e-4,
        wobble_s: 0.5,
        gyro_walk: 1e-3,
        heading_offset_rad: 2e-3,
        clock_offset_s: 2e-3,
    };

    /// k_s^2 d, with d the mean of both wheels' rolling \[m^2\].
    pub fn travel_variance_m2(&self, rolled_m: f64) -> f64 {
        self.travel_walk * self.travel_walk * rolled_m
    }

    /// k_theta^2 d \[rad^2\].
    pub fn heading_variance_rad2(&self, rolled_m: f64) -> f64 {
        self.heading_walk * self.heading_walk * rolled_m
    }

    /// Correlation of (3) over a time.
    pub fn wobble_fade(&self, t_s: f64) -> f64 {
        (-t_s / self.wobble_s).exp()
    }

    /// The same, where each pose was the mean of several: white noise falls by the root of their number.
    pub(crate) fn of_one_pose(self, poses_in_one: f64) -> Self {
        Self {
            position_sigma_m: self.position_sigma_m * poses_in_one.sqrt(),
            heading_sigma_rad: self.heading_sigma_rad * poses_in_one.sqrt(),
            ..self
        }
    }

    /// The same with all sigmas scaled by a factor.
    pub(crate) fn times(self, size: f64) -> Self {
        let mut numbers = self.to_array();
        for (i, number) in numbers.iter_mut().enumerate() {
            if i != WOBBLE_S {
                *number *= size;
            }
        }
        Self::from_array(numbers)
    }

    /// As numbers, for a search.
    pub(crate) fn to_array(self) -> [f64; NUMBERS] {
        [
            self.position_sigma_m,
            self.heading_sigma_rad,
            self.travel_walk,
            self.heading_walk,
            self.position_wobble_m,
            self.heading_wobble_rad,
            self.wobble_s,
            self.gyro_walk,
            self.heading_offset_rad,
            self.clock_offset_s,
        ]
    }

    /// From numbers.
    pub(crate) fn from_array(numbers: [f64; NUMBERS]) -> Self {
        Self {
            position_sigma_m: numbers[0],
            heading_sigma_rad: numbers[1],
            travel_walk: numbers[2],
            heading_walk: numbers[3],
            position_wobble_m: numbers[4],
            heading_wobble_rad: numbers[5],
            wobble_s: numbers[6],
            gyro_walk: numbers[7],
            heading_offset_rad: numbers[8],
            clock_offset_s: numbers[9],
        }
    }
}

/// How many numbers make up the noise.
pub(crate) const NUMBERS: usize = 10;

/// Of them, the one that is a time and no sigma.
pub(crate) const WOBBLE_S: usize = 6;
