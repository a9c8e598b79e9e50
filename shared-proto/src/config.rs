//! The robot's configuration, in SI units, and its permitted ranges.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::driver::DriverConfig;
use crate::name::Name;
use crate::pair::{Wheel, WheelPair};

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
    /// The voltage that a motion should take, before any feedback.
    pub feedforward: FeedforwardConfig,
    /// What no motion may exceed.
    pub limits: LimitsConfig,
    /// When to stop.
    pub protection: ProtectionConfig,
    /// How sure the odometry is.
    #[serde(default)]
    pub odometry: OdometryConfig,
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

/// Gains of the travel controller. Duty is a share of the nominal supply, -1 to 1.
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

/// The voltage that a motion should take, before any feedback.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(deny_unknown_fields)]
pub struct FeedforwardConfig {
    /// The left wheel's.
    pub left: WheelFeedforward,
    /// The right wheel's.
    pub right: WheelFeedforward,
    /// The nominal supply, at which the gains of `pid` hold \[V\]: the duty is scaled by it over the measured
    /// supply, by a half to two. 0: the duty is not scaled, and the supply is taken for
    /// [`SUPPLY_V_UNKNOWN`](Self::SUPPLY_V_UNKNOWN).
    #[serde(default)]
    pub supply_v: f64,
}

impl FeedforwardConfig {
    /// The supply where none is configured \[V\].
    pub const SUPPLY_V_UNKNOWN: f64 = 12.0;

    /// The supply that duties of the configuration are shares of \[V\].
    pub const fn nominal_v(&self) -> f64 {
        if self.supply_v.to_bits() << 1 == 0 { Self::SUPPLY_V_UNKNOWN } else { self.supply_v }
    }

    /// One wheel's kS forwards and backwards, kV \[s/m\] and kA \[s^2/m\], as shares of the nominal supply.
    #[inline(never)]
    pub fn shares(&self, wheel: Wheel) -> [f64; 4] {
        let WheelFeedforward { ks_forward_v, ks_backward_v, kv_v_s_per_m, ka_v_s2_per_m } =
            *self.wheel(wheel);
        let share = 1.0 / self.nominal_v();
        let mut shares = [ks_forward_v, ks_backward_v, kv_v_s_per_m, ka_v_s2_per_m];
        for value in &mut shares {
            *value *= share;
        }
        shares
    }

    /// One wheel's.
    pub const fn wheel(&self, wheel: Wheel) -> &WheelFeedforward {
        match wheel {
            Wheel::Left => &self.left,
            Wheel::Right => &self.right,
        }
    }
}

/// How one wheel's motor answers: V = kS sign(v) + kV v + kA dv/dt, in travel of the wheel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(deny_unknown_fields)]
pub struct WheelFeedforward {
    /// Voltage that overcomes friction forwards, kS+ \[V\].
    pub ks_forward_v: f64,
    /// Voltage that overcomes friction backwards, kS-, positive \[V\].
    pub ks_backward_v: f64,
    /// Voltage per speed, kV \[V s/m\].
    pub kv_v_s_per_m: f64,
    /// Voltage per acceleration, kA \[V s^2/m\].
    pub ka_v_s2_per_m: f64,
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

/// How sure the odometry is: what the covariance of the pose in the telemetry is computed from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[serde(default, deny_unknown_fields)]
pub struct OdometryConfig {
    /// Random walk of each wheel's travel: its standard deviation after one metre of rolling \[m/sqrt(m)\].
    pub noise_m_per_sqrt_m: f64,
    /// Standard deviation of [`GeometryConfig::wheel_weight`], W_T.
    pub wheel_weight_sd: f64,
    /// Standard deviation of [`GeometryConfig::track_width_m`], b \[m\].
    pub track_width_sd_m: f64,
}

impl OdometryConfig {
    /// Of a robot on a hard floor that nobody has calibrated.
    ///
    /// - The noise lets the heading of the paper's robot wander by 4 mrad/sqrt(m), n sqrt(2) / b: twice the centre of
    ///   `explain`'s prior (`OdometryNoise::TYPICAL` in `robot-model`), since tyres also creep. With it the squared errors of
    ///   simulated robots, over their variances, are 3.4 in the mean where 3 are right; with half of it 4.5.
    /// - Wheels of one type differ by some tenths of a per cent; the paper's by 0.8 %.
    /// - A tyre that is 15 mm wide stands somewhere on its width: 15 mm / sqrt(12), as a flat distribution has it.
    pub const UNCALIBRATED: Self =
        Self { noise_m_per_sqrt_m: 0.001, wheel_weight_sd: 0.005, track_width_sd_m: 0.004 };
}

impl Default for OdometryConfig {
    fn default() -> Self {
        Self::UNCALIBRATED
    }
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
        pub(crate) static RANGES: [(f64, f64); NUMBERS] = [$(($min, $max)),*];
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
    "feedforward.left.ks_forward_v"      "V"       0.0   ..= 30.0    feedforward.left.ks_forward_v;
    "feedforward.left.ks_backward_v"     "V"       0.0   ..= 30.0    feedforward.left.ks_backward_v;
    "feedforward.left.kv_v_s_per_m"      "V s/m"   0.0   ..= 60000.0 feedforward.left.kv_v_s_per_m;
    "feedforward.left.ka_v_s2_per_m"     "V s^2/m" 0.0   ..= 6000.0  feedforward.left.ka_v_s2_per_m;
    "feedforward.right.ks_forward_v"     "V"       0.0   ..= 30.0    feedforward.right.ks_forward_v;
    "feedforward.right.ks_backward_v"    "V"       0.0   ..= 30.0    feedforward.right.ks_backward_v;
    "feedforward.right.kv_v_s_per_m"     "V s/m"   0.0   ..= 60000.0 feedforward.right.kv_v_s_per_m;
    "feedforward.right.ka_v_s2_per_m"    "V s^2/m" 0.0   ..= 6000.0  feedforward.right.ka_v_s2_per_m;
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
    "odometry.noise_m_per_sqrt_m"       "m/sqrt(m)" 0.0 ..= 0.1     odometry.noise_m_per_sqrt_m;
    "odometry.wheel_weight_sd"          ""        0.0   ..= 0.25    odometry.wheel_weight_sd;
    "odometry.track_width_sd_m"         "m"       0.0   ..= 0.5     odometry.track_width_sd_m;
    "driver.pwm_hz"                     "Hz"      5000.0 ..= 100000.0 driver.pwm_hz;
];

impl Config {
    /// Every numeric field. A field's place in this list is its number in [`ConfigError`](crate::ConfigError).
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
}

impl Default for Config {
    /// The paper's robot: 3.6 cm wheels, 37.2 cm apart, 900 counts per turn, no gear, equal wheels.
    ///
    /// The gains are for a 12 V gear motor of about 2.2 turns/s without load, as in the simulator's
    /// standard robot: 0.5 m/s at full duty, of which the speed limit leaves a fifth to the loop.
    fn default() -> Self {
        let encoder = EncoderConfig { counts_per_rev: 900.0, gear_reduction: 1.0, reversed: false };
        let motor = WheelFeedforward {
            ks_forward_v: 0.48,
            ks_backward_v: 0.48,
            kv_v_s_per_m: 24.0,
            ka_v_s2_per_m: 0.768,
        };
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
            feedforward: FeedforwardConfig { left: motor, right: motor, supply_v: 12.0 },
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
            odometry: OdometryConfig::default(),
            driver: DriverConfig::default(),
        }
    }
}
