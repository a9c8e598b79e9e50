//! Whether a configuration is one that a robot can have; why not, in words.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::config::{Config, FieldRange, RANGES};
use crate::driver::{AtFault, Driver, DriverConfig};
use crate::float_order::is_above;
use crate::pair::Wheel;
use crate::readable::Readable;

impl Config {
    /// Refuses a value outside its range, and names the field.
    pub fn validate(&self) -> Result<(), ConfigError> {
        for (number, (&value, (min, max))) in self.numbers().into_iter().zip(&RANGES).enumerate() {
            if is_outside(value, *min, *max) {
                return Err(ConfigError::OutOfRange { field: number as u8, value });
            }
        }
        for wheel in Wheel::BOTH {
            let q = self.meters_per_count(self.encoder.get(wheel));
            if is_outside(q, *Self::METERS_PER_COUNT.start(), *Self::METERS_PER_COUNT.end()) {
                return Err(ConfigError::DistancePerCount { wheel, meters: q });
            }
        }
        let DriverConfig { name: driver, pwm_hz: hz, at_fault, .. } = self.driver;
        if is_outside(hz, 0.0, driver.facts().pwm_hz_max.into()) {
            return Err(ConfigError::PwmFrequency { driver, hz });
        }
        if !self.driver.can_do_at_fault() {
            return Err(ConfigError::AtFault { driver, at_fault });
        }
        Ok(())
    }
}

/// Compares by IEEE 754's totalOrder: NaN is outside, whatever its sign. Both zeros are equal.
fn is_outside(value: f64, min: f64, max: f64) -> bool {
    let value = value + 0.0;
    is_above(min, value) || is_above(value, max)
}

/// Why a configuration is refused.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ConfigError {
    /// A field of [`Config::FIELDS`] is outside its range, or not a number.
    OutOfRange {
        /// Its place in [`Config::FIELDS`].
        field: u8,
        /// The value that was refused.
        value: f64,
    },
    /// Radius, counts and gear give a distance per count outside [`Config::METERS_PER_COUNT`].
    DistancePerCount {
        /// The wheel in question.
        wheel: Wheel,
        /// Its distance per count \[m\].
        meters: f64,
    },
    /// The driver does not bear this PWM frequency.
    PwmFrequency {
        /// The driver.
        driver: Driver,
        /// The frequency \[Hz\].
        hz: f64,
    },
    /// The driver cannot do this with the motors.
    AtFault {
        /// The driver.
        driver: Driver,
        /// What was wanted.
        at_fault: AtFault,
    },
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match *self {
            ConfigError::OutOfRange { field, value } => match Config::FIELDS.get(field as usize) {
                Some(FieldRange { path, unit, min, max, .. }) => {
                    let space = if unit.is_empty() { "" } else { " " };
                    let value = Readable(value);
                    write!(f, "{path} = {value}: must be from {min} to {max}{space}{unit}")
                }
                None => {
                    let value = Readable(value);
                    write!(f, "field {field} of the configuration = {value}: out of range")
                }
            },
            ConfigError::DistancePerCount { wheel, meters } => write!(
                f,
                "the {} wheel travels {} m per count (from geometry.wheel_radius_m, \
                 encoder.{0}.counts_per_rev and encoder.{0}.gear_reduction): must be from {} to {} m",
                wheel.name(),
                Readable(meters),
                Config::METERS_PER_COUNT.start(),
                Config::METERS_PER_COUNT.end(),
            ),
            ConfigError::PwmFrequency { driver, hz } => write!(
                f,
                "driver.pwm_hz = {}: the driver {} takes at most {} Hz",
                Readable(hz),
                driver.name(),
                driver.facts().pwm_hz_max,
            ),
            ConfigError::AtFault { driver, at_fault } => write!(
                f,
                "driver.at_fault = {}: the driver {} cannot {}",
                at_fault.name(),
                driver.name(),
                if at_fault == AtFault::Brake {
                    "brake the motors"
                } else {
                    "let the motors coast"
                },
            ),
        }
    }
}

impl core::error::Error for ConfigError {}
