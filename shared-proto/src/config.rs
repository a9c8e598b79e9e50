//! The robot's configuration, in SI units, and its permitted ranges.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::driver::{AtFault, Driver, DriverConfig};
use crate::float_order::is_above;
use crate::name::Name;
use crate::pair::{Wheel, WheelPair};
use crate::readable::Readable;

/// Everything that differs from robot to robot.
///
/// Formats for people, such as TOML, name each part; in bytes the same values follow one another.
#[derive(Clone, Debug, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(deny_unknown_fields, remote = "Self")]
pub struct Config {
    /// The robot's name, given by its owner.
    pub name: Name,
    /// Wheels and track.
    pub geometry: GeometryConfig,
    /// Each wheel's encoder.
    pub encoder: WheelPair<EncoderConfig>,
    /// Each wheel's motor.
    pub motor: WheelPair<MotorConfig>,
    /// The feedback loop, the same for both wheels.
    pub pid: PidConfig,
    /// The duty that a motion should take, before any feedback.
    pub feedforward: FeedforwardConfig,
    /// What no motion may exceed.
    pub limits: LimitsConfig,
    /// When to stop.
    pub protection: ProtectionConfig,
    /// The motor driver.
    #[serde(default)]
    pub driver: DriverConfig,
}

/// Wheels and track.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(deny_unknown_fields)]
pub struct GeometryConfig {
    /// Radius of the left wheel, R_L \[m\].
    pub wheel_radius_m: f64,
    /// Distance between the wheels' contact points, b \[m\].
    pub track_width_m: f64,
    /// Right wheel's radius relative to the left one's, W_T = R_R / R_L.
    pub wheel_weight: f64,
    /// Heading change per distance driven, with equal wheel travel, c \[rad/m\]: to the left if positive,
    /// forwards and backwards. Every motion compensates for this; 0 means no compensation.
    #[serde(default)]
    pub heading_pull_rad_per_m: f64,
}

/// One wheel's encoder.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(deny_unknown_fields)]
pub struct EncoderConfig {
    /// Counts (all four edges) per turn of the encoder, N; may be fractional.
    pub counts_per_rev: f64,
    /// Turns of the encoder per turn of the wheel, the paper's 1/g; may be fractional.
    pub gear_reduction: f64,
    /// True if the count falls when the wheel rolls forward.
    pub reversed: bool,
}

/// One wheel's motor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(deny_unknown_fields)]
pub struct MotorConfig {
    /// True if positive duty turns the wheel backwards.
    pub reversed: bool,
}

/// Gains of the travel controller. Duty is a share of the supply, -1 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(deny_unknown_fields)]
pub struct PidConfig {
    /// Duty per metre of travel error \[1/m\].
    pub kp_per_m: f64,
    /// Duty per metre-second of travel error \[1/(m s)\].
    pub ki_per_m_s: f64,
    /// Duty per metre per second of speed error \[s/m\].
    pub kd_s_per_m: f64,
}

/// The duty that a motion should take, before any feedback.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(deny_unknown_fields)]
pub struct FeedforwardConfig {
    /// Duty that overcomes friction, with the sign of the speed.
    pub ks: f64,
    /// Duty per speed \[s/m\].
    pub kv_s_per_m: f64,
    /// Duty per acceleration \[s^2/m\].
    pub ka_s2_per_m: f64,
    /// The supply at which these and the gains of `pid` hold \[V\]: the duty is scaled by it over the measured
    /// supply, by a half to two. 0: the duty is not scaled.
    #[serde(default)]
    pub supply_v: f64,
}

/// What no motion may exceed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(deny_unknown_fields)]
pub struct LimitsConfig {
    /// A wheel's fastest commanded speed \[m/s\].
    pub speed_mps_max: f64,
    /// A wheel's largest commanded acceleration \[m/s^2\].
    pub acceleration_mps2_max: f64,
    /// Deceleration of a controlled stop \[m/s^2\].
    pub stop_deceleration_mps2: f64,
    /// Largest duty.
    pub duty_max: f64,
    /// Largest change of duty \[1/s\].
    pub duty_slew_per_s: f64,
    /// How long the robot holds its place after a motion before the duty goes to zero \[s\].
    #[serde(default)]
    pub hold_s: f64,
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(deny_unknown_fields)]
pub struct ProtectionConfig {
    /// A wheel this far from its setpoint is a fault \[m\].
    pub following_error_m_max: f64,
    /// A driven wheel that does not turn for this long is a fault \[s\].
    pub stall_time_s: f64,
    /// Largest duty while the encoders' signs are checked, before the loop closes, at the nominal supply.
    pub probe_duty_max: f64,
    /// Supply below this is a fault \[V\]; 0: the supply is not measured, and duty is not scaled by it.
    pub supply_v_min: f64,
    /// Supply above this is a fault \[V\]; 0: no supply is.
    #[serde(default)]
    pub supply_v_max: f64,
    /// Silence on the link for this long, while driving, is a fault \[s\].
    pub link_timeout_s: f64,
}

/// One numeric field of [`Config`]: its name, unit and permitted range, both ends included.
#[derive(Clone, Copy, Debug)]
pub struct FieldRange {
    /// Path in the configuration, `geometry.wheel_weight`.
    pub path: &'static str,
    /// Unit, `""` for a ratio.
    pub unit: &'static str,
    /// Smallest permitted value.
    pub min: f64,
    /// Largest permitted value.
    pub max: f64,
    /// Reads the field.
    pub read: fn(&Config) -> f64,
}

macro_rules! fields {
    ($($path:literal $unit:literal $min:literal ..= $max:literal $($name:ident).+;)*) => {
        /// How many [`Config::FIELDS`] there are.
        pub(crate) const NUMBERS: usize = [$($path),*].len();

        impl Config {
            const TABLE: [FieldRange; NUMBERS] = [$(
                FieldRange { path: $path, unit: $unit, min: $min, max: $max, read: |c| c.$($name).+ }
            ),*];

            /// The numbers, in the order of [`Config::FIELDS`].
            #[inline(never)]
            pub(crate) fn numbers(&self) -> [&f64; NUMBERS] {
                [$(&self.$($name).+),*]
            }

            /// The numbers, to be changed.
            #[inline(never)]
            pub(crate) fn numbers_mut(&mut self) -> [&mut f64; NUMBERS] {
                [$(&mut self.$($name).+),*]
            }
        }

        /// The ranges alone: a board does not need the names.
        static RANGES: [(f64, f64); NUMBERS] = [$(($min, $max)),*];
    };
}

#[rustfmt::skip]
fields![
    "geometry.wheel_radius_m"           "m"       0.005 ..= 1.0     geometry.wheel_radius_m;
    "geometry.track_width_m"            "m"       0.02  ..= 5.0     geometry.track_width_m;
    "geometry.wheel_weight"             ""        0.8   ..= 1.25    geometry.wheel_weight;
    "geometry.heading_pull_rad_per_m"   "rad/m"   -0.1  ..= 0.1     geometry.heading_pull_rad_per_m;
    "encoder.left.counts_per_rev"       ""        1.0   ..= 1e6     encoder.left.counts_per_rev;
    "encoder.left.gear_reduction"       ""        0.01  ..= 1000.0  encoder.left.gear_reduction;
    "encoder.right.counts_per_rev"      ""        1.0   ..= 1e6     encoder.right.counts_per_rev;
    "encoder.right.gear_reduction"      ""        0.01  ..= 1000.0  encoder.right.gear_reduction;
    "pid.kp_per_m"                      "1/m"     0.0   ..= 10000.0 pid.kp_per_m;
    "pid.ki_per_m_s"                    "1/(m s)" 0.0   ..= 10000.0 pid.ki_per_m_s;
    "pid.kd_s_per_m"                    "s/m"     0.0   ..= 1000.0  pid.kd_s_per_m;
    "feedforward.ks"                    ""        0.0   ..= 0.5     feedforward.ks;
    "feedforward.kv_s_per_m"            "s/m"     0.0   ..= 1000.0  feedforward.kv_s_per_m;
    "feedforward.ka_s2_per_m"           "s^2/m"   0.0   ..= 100.0   feedforward.ka_s2_per_m;
    "feedforward.supply_v"              "V"       0.0   ..= 60.0    feedforward.supply_v;
    "limits.speed_mps_max"              "m/s"     0.001 ..= 20.0    limits.speed_mps_max;
    "limits.acceleration_mps2_max"      "m/s^2"   0.001 ..= 100.0   limits.acceleration_mps2_max;
    "limits.stop_deceleration_mps2"     "m/s^2"   0.05  ..= 100.0   limits.stop_deceleration_mps2;
    "limits.duty_max"                   ""        0.05  ..= 1.0     limits.duty_max;
    "limits.duty_slew_per_s"            "1/s"     0.5   ..= 1000.0  limits.duty_slew_per_s;
    "limits.hold_s"                     "s"       0.0   ..= 3600.0  limits.hold_s;
    "protection.following_error_m_max"      "m"       0.001 ..= 1.0     protection.following_error_m_max;
    "protection.stall_time_s"           "s"       0.01  ..= 0.09    protection.stall_time_s;
    "protection.probe_duty_max"         ""        0.02  ..= 0.5     protection.probe_duty_max;
    "protection.supply_v_min"           "V"       0.0   ..= 60.0    protection.supply_v_min;
    "protection.supply_v_max"           "V"       0.0   ..= 60.0    protection.supply_v_max;
    "protection.link_timeout_s"         "s"       0.05  ..= 0.24    protection.link_timeout_s;
    "driver.pwm_hz"                     "Hz"      5000.0 ..= 100000.0 driver.pwm_hz;
];

impl Config {
    /// Every numeric field. A field's place in this list is its number in [`ConfigError`].
    ///
    /// The ranges keep every quantity inside the firmware's fixed-point types: travel to 2^31 m
    /// in steps of 2^-32 m, metres per count above 1 um, ramps below 1000 s.
    pub const FIELDS: &'static [FieldRange] = &Self::TABLE;

    /// Smallest and largest permitted distance per count, Q \[m\]: between them, 10 km stay within
    /// one count in 64 fractional bits.
    pub const METERS_PER_COUNT: core::ops::RangeInclusive<f64> = 1e-6..=0.1;

    /// Distance per count of an encoder on a wheel of the configured radius, Q = 2 pi R / (N * reduction) \[m\].
    pub fn meters_per_count(&self, encoder: &EncoderConfig) -> f64 {
        core::f64::consts::TAU * self.geometry.wheel_radius_m
            / (encoder.counts_per_rev * encoder.gear_reduction)
    }

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
                "driver.pwm_hz = {}: a driver of the kind {} bears at most {} Hz",
                Readable(hz),
                driver.name(),
                driver.facts().pwm_hz_max,
            ),
            ConfigError::AtFault { driver, at_fault } => write!(
                f,
                "driver.at_fault = {}: a driver of the kind {} cannot {}",
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

impl Default for Config {
    /// The paper's robot: 3.6 cm wheels, 37.2 cm apart, 900 counts per turn, no gear, equal wheels.
    ///
    /// The gains are for a 12 V gear motor of about 2.2 turns/s without load, as in the simulator's
    /// standard robot: 0.5 m/s at full duty, of which the speed limit leaves a fifth to the loop.
    fn default() -> Self {
        let encoder = EncoderConfig { counts_per_rev: 900.0, gear_reduction: 1.0, reversed: false };
        Self {
            name: Name::default(),
            geometry: GeometryConfig {
                wheel_radius_m: 0.036,
                track_width_m: 0.372,
                wheel_weight: 1.0,
                heading_pull_rad_per_m: 0.0,
            },
            encoder: WheelPair::both(encoder),
            motor: WheelPair::both(MotorConfig { reversed: false }),
            pid: PidConfig { kp_per_m: 40.0, ki_per_m_s: 60.0, kd_s_per_m: 1.0 },
            feedforward: FeedforwardConfig {
                ks: 0.04,
                kv_s_per_m: 2.0,
                ka_s2_per_m: 0.064,
                supply_v: 12.0,
            },
            limits: LimitsConfig {
                speed_mps_max: 0.4,
                acceleration_mps2_max: 1.0,
                stop_deceleration_mps2: 0.5,
                duty_max: 1.0,
                duty_slew_per_s: 20.0,
                hold_s: 0.0,
            },
            protection: ProtectionConfig {
                following_error_m_max: 0.02,
                stall_time_s: 0.06,
                probe_duty_max: 0.25,
                supply_v_min: 9.0,
                supply_v_max: 18.5,
                link_timeout_s: 0.2,
            },
            driver: DriverConfig::default(),
        }
    }
}
