//! How well poses are measured, and how fast dead reckoning loses its way.
//!
//! ```text
//! measured = pose + e + white noise                                                   (1)
//! var(growth of the pose's error along d metres) = k^2 d                              (2)
//! e: stationary, exp(-t/T) correlated                                                 (3)
//! ```
//!
//! (3) is whatever makes neighbouring measurements err alike without adding up: jittering time
//! stamps, a camera that is off in one place, counts that stand still. Without it, real recordings are
//! read as if dead reckoning lost its way fast, and what a long way tells is thrown away.

/// Noise of measured poses, and of the way between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryNoise {
    /// Each coordinate of a measured position, one sigma \[m\].
    pub position_sigma_m: f64,
    /// A measured heading, one sigma \[rad\].
    pub heading_sigma_rad: f64,
    /// Wandering of the position, k_s: sigma after one metre of rolling \[m/sqrt(m)\].
    pub travel_walk: f64,
    /// Wandering of the heading, k_theta: sigma after one metre of rolling \[rad/sqrt(m)\].
    pub heading_walk: f64,
    /// Of (3), each coordinate of the position, one sigma \[m\].
    pub position_wobble_m: f64,
    /// Of (3), the heading, one sigma \[rad\].
    pub heading_wobble_rad: f64,
    /// T of (3) \[s\].
    pub wobble_s: f64,
    /// Wandering of the heading by the yaw rate sensor: sigma after one second \[rad/sqrt(s)\].
    pub gyro_walk: f64,
}

impl OdometryNoise {
    /// What is taken for typical before any data: a camera of a millimetre over a hard floor.
    pub const TYPICAL: Self = Self {
        position_sigma_m: 1.5e-3,
        heading_sigma_rad: 2e-3,
        travel_walk: 1e-3,
        heading_walk: 2e-3,
        position_wobble_m: 5e-4,
        heading_wobble_rad: 7e-4,
        wobble_s: 0.5,
        gyro_walk: 1e-3,
    };

    /// k_s^2 d, with d the mean of both wheels' rolling \[m^2\].
    pub fn travel_variance_m2(&self, rolled_m: f64) -> f64 {
        self.travel_walk * self.travel_walk * rolled_m
    }

    /// k_theta^2 d \[rad^2\].
    pub fn heading_variance_rad2(&self, rolled_m: f64) -> f64 {
        self.heading_walk * self.heading_walk * rolled_m
    }

    /// How much of (3) is left after a time.
    pub fn wobble_fade(&self, t_s: f64) -> f64 {
        (-t_s / self.wobble_s).exp()
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
        ]
    }

    /// From numbers.
    pub(crate) fn from_array(it: [f64; NUMBERS]) -> Self {
        Self {
            position_sigma_m: it[0],
            heading_sigma_rad: it[1],
            travel_walk: it[2],
            heading_walk: it[3],
            position_wobble_m: it[4],
            heading_wobble_rad: it[5],
            wobble_s: it[6],
            gyro_walk: it[7],
        }
    }
}

/// How many numbers make up the noise.
pub(crate) const NUMBERS: usize = 8;

/// Which of them are given, in the order of [`OdometryNoise::to_array`].
pub(crate) type Given = [bool; NUMBERS];

/// Width of what is plausible before any data, in e-folds: a factor of four either way.
const PRIOR_EFOLDS: f64 = 1.4;

/// What fades faster is white at any usual rate of a camera \[s\].
const WOBBLE_S_MIN: f64 = 0.02;
/// What fades slower would be an effect, and is to be found as one \[s\].
const WOBBLE_S_MAX: f64 = 5.0;

/// How far to look for the noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Search {
    /// From two starts: errors that add up, and errors that fade.
    Wide,
    /// Round what was found before.
    Near,
}

/// The noise that makes `minus_two_log_likelihood` least, starting at `start`.
///
/// A search along each axis of the logarithms, with steps that halve. What is typical counts as
/// much as one measurement would, so that four poses in all do not give a noise of zero.
pub(crate) fn most_likely(
    start: OdometryNoise,
    given: Given,
    search: Search,
    mut minus_two_log_likelihood: impl FnMut(&OdometryNoise) -> f64,
) -> OdometryNoise {
    let typical = OdometryNoise::TYPICAL.to_array();
    let mut cost = |noise: [f64; NUMBERS]| {
        let prior: f64 = (0..NUMBERS)
            .filter(|i| !given[*i])
            .map(|i| ((noise[i] / typical[i]).ln() / PRIOR_EFOLDS).powi(2))
            .sum();
        prior + minus_two_log_likelihood(&OdometryNoise::from_array(noise))
    };
    match search {
        Search::Near => descend(start.to_array(), &given, 0.2, &mut cost).0,
        Search::Wide => {
            let fading = OdometryNoise {
                position_wobble_m: 2e-3,
                heading_wobble_rad: 1e-2,
                wobble_s: 3.0,
                ..start
            };
            let (adds_up, cost_up) = descend(start.to_array(), &given, 0.8, &mut cost);
            let (fades, cost_fades) = descend(fading.to_array(), &given, 0.8, &mut cost);
            if cost_fades < cost_up { fades } else { adds_up }
        }
    }
}

fn descend(
    start: [f64; NUMBERS],
    given: &Given,
    mut step: f64,
    cost: &mut impl FnMut([f64; NUMBERS]) -> f64,
) -> (OdometryNoise, f64) {
    let mut best = start;
    let mut least = cost(best);
    // The way each number went last is tried first.
    let mut way = [1.0; NUMBERS];
    // To 5 % of a sigma: the chi of the residuals is then right to 5 % at worst.
    while step > 0.05 {
        let mut improved = false;
        for i in (0..NUMBERS).filter(|i| !given[*i]) {
            for _ in 0..2 {
                let mut trial = best;
                trial[i] *= f64::exp(way[i] * step);
                trial[6] = trial[6].clamp(WOBBLE_S_MIN, WOBBLE_S_MAX);
                let value = cost(trial);
                if value < least - 0.1 {
                    (best, least, improved) = (trial, value, true);
                    break;
                }
                way[i] = -way[i];
            }
        }
        if !improved {
            step /= 2.0;
        }
    }
    (OdometryNoise::from_array(best), least)
}
