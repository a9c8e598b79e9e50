//! What is too small to matter?

use crate::recording::campaign::Prepared;
use crate::recording::odometry_noise::OdometryNoise;

/// What moves the robot by less than this share of the noise of one pose is not worth correcting.
const SHARE: f64 = 0.1;

/// What moves the robot by less than this is not worth correcting, unless the user says otherwise \[m\].
pub(super) fn tolerance_m(prepared: &Prepared, noise: &OdometryNoise) -> f64 {
    let noise = noise.of_one_pose(prepared.poses_in_one);
    SHARE * noise.position_sigma_m.hypot(noise.position_wobble_m)
}

/// An error smaller than this is none: that, or the rounding to whole counts \[m\].
pub(super) fn resolved_m(prepared: &Prepared, noise: &OdometryNoise) -> f64 {
    tolerance_m(prepared, noise).max(prepared.robot.rounding_m())
}
