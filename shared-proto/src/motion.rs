//! Motions that a robot can be told to make.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::config::Config;
use crate::float_order::is_above;
use crate::pair::WheelPair;

/// Identifies a motion, so that a repeated command is not driven twice.
///
/// The host chooses the number; none of the last nine motions may have had the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MotionId(pub u32);

/// A trapezoidal motion of both wheels: straight, reverse, spin and arc are one command.
///
/// Both wheels start and end together. `cruise` and `acceleration` hold for the wheel that goes
/// farther; the other one follows in proportion. From a standing start the path is therefore a
/// line, a spin or one circular arc throughout.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Drive {
    /// Names this motion.
    pub motion: MotionId,
    /// The unit of the three quantities below.
    pub unit: TravelUnit,
    /// How far each wheel travels from where it is now, backwards if negative \[unit\].
    pub distance: WheelPair<f64>,
    /// Speed between the ramps, positive \[unit/s\].
    pub cruise: f64,
    /// Steepness of the ramps, positive \[unit/s^2\].
    pub acceleration: f64,
    /// When to start, from a standstill, on the robot's clock \[us since power-on\]; at once if `None`.
    ///
    /// So a command that had to be repeated starts no later than one that arrived at once.
    pub start_us: Option<u64>,
}

impl Drive {
    /// Farthest that one command goes \[m\].
    pub const DISTANCE_M_MAX: f64 = 20_000.0;
    /// Longest that one command takes \[s\].
    pub const DURATION_S_MAX: f64 = 2_000_000.0;
    /// Farthest that [`Drive::start_us`] may lie ahead \[us\].
    pub const START_AHEAD_US_MAX: u64 = 10_000_000;
    /// Longest ramp \[s\].
    pub const RAMP_S_MAX: f64 = 1000.0;

    /// The motion in SI units, if it keeps to the limits of a valid configuration.
    ///
    /// Robot and host both check with this. Two more limits depend on the robot's present state, so only the
    /// robot checks them: how long the ramps take, and whether the start time is still ahead.
    #[inline]
    pub fn to_si(&self, config: &Config) -> Result<DriveSi, MotionError> {
        let positive = |value: f64| value.is_finite() && is_above(value, 0.0);
        if !positive(self.cruise)
            || !positive(self.acceleration)
            || !self.distance.all(f64::is_finite)
        {
            return Err(MotionError::NotPositive);
        }
        let unit_m = match self.unit {
            TravelUnit::Meter => 1.0,
            TravelUnit::WheelRevolution => core::f64::consts::TAU * config.geometry.wheel_radius_m,
        };
        let si = DriveSi {
            distance_m: self.distance.map(|distance| distance * unit_m),
            cruise_mps: self.cruise * unit_m,
            acceleration_mps2: self.acceleration * unit_m,
        };
        if si.distance_m.any(|distance_m| is_above(distance_m.abs(), Drive::DISTANCE_M_MAX)) {
            return Err(MotionError::TooFar);
        }
        if is_above(si.cruise_mps, config.limits.speed_mps_max) {
            return Err(MotionError::TooFast);
        }
        if is_above(si.acceleration_mps2, config.limits.acceleration_mps2_max) {
            return Err(MotionError::TooSteep);
        }
        Ok(si)
    }
}

/// A [`Drive`] within its limits, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveSi {
    /// Travel of each wheel \[m\].
    pub distance_m: WheelPair<f64>,
    /// Speed between the ramps \[m/s\].
    pub cruise_mps: f64,
    /// Steepness of the ramps \[m/s^2\].
    pub acceleration_mps2: f64,
}

/// A velocity of the robot, for as long as the lease lasts: for joysticks and path followers.
///
/// The same motion may be commanded again with other numbers; the command with the later lease counts. When the
/// lease ends the robot brakes along a ramp and stays armed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Velocity {
    /// Names this motion.
    pub motion: MotionId,
    /// Speed of the middle between the wheels, forward positive \[m/s\].
    pub forward_mps: f64,
    /// Turn rate, to the left positive \[rad/s\].
    pub turn_rad_s: f64,
    /// Acceleration of the wheel whose speed changes most, above zero \[m/s^2\].
    pub acceleration_mps2: f64,
}

impl Velocity {
    /// The wheels' speeds \[m/s\], v -+ omega b / 2 with the track width b, if they keep to the limits of a valid
    /// configuration. Robot and host both check with this.
    #[inline(never)]
    pub fn wheels_mps(&self, config: &Config) -> Result<WheelPair<f64>, MotionError> {
        let Self { forward_mps, turn_rad_s, acceleration_mps2, .. } = *self;
        if !forward_mps.is_finite()
            || !turn_rad_s.is_finite()
            || !acceleration_mps2.is_finite()
            || !is_above(acceleration_mps2, 0.0)
        {
            return Err(MotionError::NotPositive);
        }
        let sideways = 0.5 * turn_rad_s * config.geometry.track_width_m;
        let wheels = WheelPair::new(forward_mps - sideways, forward_mps + sideways);
        if wheels.any(|speed| is_above(speed.abs(), config.limits.speed_mps_max)) {
            return Err(MotionError::TooFast);
        }
        if is_above(acceleration_mps2, config.limits.acceleration_mps2_max) {
            return Err(MotionError::TooSteep);
        }
        Ok(wheels)
    }
}

/// The unit of a [`Drive`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TravelUnit {
    /// Metres on the ground.
    Meter,
    /// Turns of a wheel of the configured radius: 2 pi R metres for both wheels.
    WheelRevolution,
}

/// Why a motion is refused; nothing moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MotionError {
    /// A quantity is NaN or infinite, or acceleration or cruise is not above zero.
    NotPositive,
    /// Both distances are zero.
    NoDistance,
    /// Farther than [`Drive::DISTANCE_M_MAX`].
    TooFar,
    /// Cruise above `limits.speed_mps_max`.
    TooFast,
    /// Acceleration above `limits.acceleration_mps2_max`.
    TooSteep,
    /// A ramp above [`Drive::RAMP_S_MAX`], or a motion above [`Drive::DURATION_S_MAX`]; of a voltage, a ramp below
    /// [`Voltage::RAMP_V_PER_S_MIN`](crate::Voltage::RAMP_V_PER_S_MIN) or a time above
    /// [`Voltage::DURATION_S_MAX`](crate::Voltage::DURATION_S_MAX).
    TooLong,
    /// [`Drive::start_us`] has passed, or is more than [`Drive::START_AHEAD_US_MAX`] ahead.
    Start,
    /// A voltage above [`Voltage::VOLTS_MAX`](crate::Voltage::VOLTS_MAX).
    TooHigh,
}

impl core::fmt::Display for MotionError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            MotionError::NotPositive => {
                "cruise and acceleration must be numbers above zero, all others must be numbers"
            }
            MotionError::NoDistance => "both wheels' distances are zero",
            MotionError::TooFar => "farther than 20 km",
            MotionError::TooFast => "faster than limits.speed_mps_max",
            MotionError::TooSteep => "more acceleration than limits.acceleration_mps2_max",
            MotionError::TooLong => {
                "a ramp would take more than 1000 s, or the whole motion more than 2,000,000 s"
            }
            MotionError::Start => "the start time must lie ahead, by at most 10 s",
            MotionError::TooHigh => "a voltage above 60 V",
        })
    }
}

impl core::error::Error for MotionError {}
