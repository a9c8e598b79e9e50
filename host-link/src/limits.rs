//! Whether the robot would refuse a motion, known before it is commanded.
//!
//! The robot checks each motion itself; its answer is what counts.

use std::f64::consts::TAU;

use shared_proto::{Config, Drive, MotionError, TravelUnit};

use crate::motion::Motion;

/// Host and robot may round a limit differently; what is this close to it is left to the robot.
const ROUNDING: f64 = 1e-9;

/// The length over ground of one unit of a motion \[m\].
pub fn unit_m(motion: &Motion, config: &Config) -> f64 {
    match motion.unit {
        TravelUnit::Meter => 1.0,
        TravelUnit::WheelRevolution => TAU * config.geometry.wheel_radius_m,
    }
}

/// What a robot with this configuration would answer to a motion from standstill.
pub fn check(motion: &Motion, config: &Config) -> Result<(), MotionError> {
    let Motion { distance, cruise, acceleration, .. } = *motion;
    let unit_m = unit_m(motion, config);
    let beyond = |value: f64, limit: f64| value * unit_m > limit * (1.0 + ROUNDING);
    if !distance.all(f64::is_finite) {
        Err(MotionError::NotPositive)
    } else if distance.any(|distance| beyond(distance.abs(), Drive::DISTANCE_M_MAX)) {
        Err(MotionError::TooFar)
    } else if beyond(cruise, config.limits.speed_mps_max) {
        Err(MotionError::TooFast)
    } else if beyond(acceleration, config.limits.acceleration_mps2_max) {
        Err(MotionError::TooSteep)
    } else if distance.all(|distance| distance == 0.0) {
        Err(MotionError::NoDistance)
    } else if motion.ramp_s() > Drive::RAMP_S_MAX || motion.duration_s() > Drive::DURATION_S_MAX {
        Err(MotionError::TooLong)
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_at_the_limits_themselves_is_left_to_the_robot() {
        let config = Config::default();
        let (cruise, acceleration) =
            (config.limits.speed_mps_max, config.limits.acceleration_mps2_max);
        let unit_m = TAU * config.geometry.wheel_radius_m;
        let turns = Motion {
            cruise: cruise / unit_m,
            acceleration: acceleration / unit_m,
            ..Motion::PAPER
        };
        let meters = Motion { unit: TravelUnit::Meter, cruise, acceleration, ..Motion::PAPER };
        for motion in [turns, meters, Motion::PAPER] {
            check(&motion, &config).unwrap();
        }
        let too_fast = Motion { cruise: cruise * 1.001, ..meters };
        assert_eq!(check(&too_fast, &config), Err(MotionError::TooFast));
        let too_steep = Motion { acceleration: acceleration * 1.001 / unit_m, ..turns };
        assert_eq!(check(&too_steep, &config), Err(MotionError::TooSteep));
    }
}
