//! What is too small to matter?
//!
//! An effect is worth correcting only if what it does is beyond doubt more than the tolerance. With p the probability of as
//! much by chance, and n effects tested, of which the most likely one was taken:
//!
//! ```text
//! z = sigmas that a normal deviate exceeds, either way, with probability n p       (Bonferroni)
//! least size = size (1 - 1.96 / z)                                                   (1)
//! ```
//!
//! The lower end of the 95 % interval of a value z sigmas from zero is the share in (1) of it, and what an effect does is
//! proportional to its value.

use crate::numeric::distributions::{SIGMAS_95, normal_sigmas};
use crate::recording::campaign::Prepared;
use crate::recording::odometry_noise::OdometryNoise;

/// What moves the robot by less than this share of the noise of one pose is not worth correcting.
const SHARE: f64 = 0.1;

/// What moves the robot by less than this is not worth correcting, unless the user says otherwise \[m\].
pub(crate) fn tolerance_m(prepared: &Prepared, noise: &OdometryNoise) -> f64 {
    let noise = noise.of_one_pose(prepared.poses_in_one);
    SHARE * noise.position_sigma_m.hypot(noise.position_wobble_m)
}

/// An error smaller than this is none: that, or the rounding to whole counts \[m\].
pub(crate) fn resolved_m(prepared: &Prepared, noise: &OdometryNoise) -> f64 {
    tolerance_m(prepared, noise).max(prepared.robot.rounding_m())
}

/// (1): what an effect of this size, so probable by chance, does at least, with so many effects asked for \[m\].
pub(crate) fn least_size_m(size_m: f64, p_value: f64, asked: usize) -> f64 {
    let sigmas = normal_sigmas((p_value * asked as f64).min(1.0));
    size_m * (1.0 - SIGMAS_95 / sigmas).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_effect_is_as_large_as_the_lower_end_of_its_interval() {
        // Four sigmas are passed in 6.3342e-5: half of it is certain. Of 16 tests in 1.01e-3: 3.286 sigmas.
        assert!((least_size_m(1e-3, 6.3342e-5, 1) / 5.1e-4 - 1.0).abs() < 1e-3);
        assert!((least_size_m(1e-3, 6.3342e-5, 16) / 4.04e-4 - 1.0).abs() < 5e-3);
        assert_eq!(
            least_size_m(1e-3, 0.02, 20),
            0.0,
            "as probable by chance as an error of one test in five"
        );
        assert_eq!(least_size_m(1e-3, 0.0, 23), 1e-3);
        assert_eq!(least_size_m(1e-3, 1.0, 23), 0.0);
    }
}
