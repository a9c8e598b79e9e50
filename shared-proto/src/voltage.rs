//! Voltages at the motors, open loop: to measure how motors answer.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::config::Config;
use crate::float_order::is_above;
use crate::motion::{MotionError, MotionId};
use crate::pair::WheelPair;

/// Voltages at both motors, without feedback, within bounds: to identify motors that no gains are known for.
///
/// The voltages change along a ramp from what they are, and are held until the time is over, a wheel has gone too far
/// or turns too fast, or the lease ends. Then both are zero at once, and the motion ends when the wheels stand. While
/// it is under way, another voltage takes its place without a stop, and any other motion is refused.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Voltage {
    /// Names this motion.
    pub motion: MotionId,
    /// Mean voltage at each motor, forward positive \[V\]. More than the supply gives, or than `limits.duty_max` of
    /// it, is not reached.
    pub volts: WheelPair<f64>,
    /// How fast the voltages change, above zero \[V/s\].
    pub ramp_v_per_s: f64,
    /// How long it takes from its first tick, ramp included, above zero \[s\].
    pub duration_s: f64,
    /// It ends once a wheel has gone this far from where it began, either way, above zero \[m\].
    pub travel_m_max: f64,
    /// It ends once a wheel turns faster than this, either way, above zero \[m/s\].
    pub speed_mps_max: f64,
}

impl Voltage {
    /// Highest voltage, either way \[V\].
    pub const VOLTS_MAX: f64 = 60.0;
    /// Slowest ramp \[V/s\].
    pub const RAMP_V_PER_S_MIN: f64 = 0.01;
    /// Longest that it takes \[s\].
    pub const DURATION_S_MAX: f64 = 60.0;
    /// Farthest that it goes \[m\].
    pub const TRAVEL_M_MAX: f64 = 20.0;

    /// An error if a quantity is out of its range, or the limit of the speed is above twice
    /// `limits.speed_mps_max`: a motor is faster without load than any motion that it is to follow.
    #[inline(never)]
    pub fn check(&self, config: &Config) -> Result<(), MotionError> {
        let Self { volts, ramp_v_per_s, duration_s, travel_m_max, speed_mps_max, .. } = *self;
        let numbers = [ramp_v_per_s, duration_s, travel_m_max, speed_mps_max];
        let positive = |value: &f64| value.is_finite() && is_above(*value, 0.0);
        if !numbers.iter().all(positive) || !volts.all(f64::is_finite) {
            return Err(MotionError::NotPositive);
        }
        if volts.any(|volts| is_above(volts.abs(), Self::VOLTS_MAX)) {
            return Err(MotionError::TooHigh);
        }
        if is_above(travel_m_max, Self::TRAVEL_M_MAX) {
            return Err(MotionError::TooFar);
        }
        if is_above(speed_mps_max, 2.0 * config.limits.speed_mps_max) {
            return Err(MotionError::TooFast);
        }
        if is_above(duration_s, Self::DURATION_S_MAX)
            || is_above(Self::RAMP_V_PER_S_MIN, ramp_v_per_s)
        {
            return Err(MotionError::TooLong);
        }
        Ok(())
    }
}
