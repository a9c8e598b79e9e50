//! What the rules compare with, from the configuration.

use fixed::types::I2F30;
use shared_proto::{Config, Wheel, WheelPair};

use super::sample::POSITION_BITS;
use crate::odometry::Odometry;
use crate::pid::REST_BAND_M;
use crate::soft_float::{max, nearest, truncate};
use crate::units::{CONTROL_HZ, MetersPerCount, saturate_i32};

/// Checkpoints in a stall time.
pub(super) const CHECKPOINTS_LEN: usize = 8;

/// A push is summed with so many bits less than a duty has.
pub(super) const PUSH_SHIFT: u32 = 12;

/// Both wheels' thresholds.
#[derive(Clone, Debug)]
pub struct Thresholds(pub(super) WheelPair<WheelThresholds>);

impl Thresholds {
    /// The thresholds of a valid configuration.
    #[inline]
    pub fn new(config: &Config) -> Self {
        let q = Odometry::new(config).meters_per_count();
        Self(WheelPair {
            left: WheelThresholds::new(config, Wheel::Left, q.left),
            right: WheelThresholds::new(config, Wheel::Right, q.right),
        })
    }

    /// Counts by which a wheel without a duty may have moved in 48 ms: 4, and what its speed limit lets it turn in 4 ms; 1 mm at
    /// least, and 4 counts and 2 mm at most.
    #[inline]
    pub fn counts_at_rest_max(&self, wheel: Wheel) -> u32 {
        let limits = self.0.get(wheel);
        // `resting_error` is four counts.
        let enough = (4 * limits.standing_advance / limits.resting_error) as u32;
        limits.counts_per_tick_max.max(enough / 2).min(enough + 4)
    }
}

/// One wheel's thresholds; travel in steps of 2^-24 m, time in ticks.
#[derive(Clone, Copy, Debug)]
pub(super) struct WheelThresholds {
    pub error_max: i32,
    pub counts_per_tick_max: u32,
    pub stall_ticks: u32,
    /// Between two checkpoints of the creep rule.
    pub checkpoint_ticks: u32,
    pub standing_advance: i32,
    pub creeping_advance: i32,
    pub reversed_run: i32,
    /// A wheel that is driven away has gone this far.
    pub runaway: i32,
    /// Duty that friction takes \[2^-30\].
    pub friction: i64,
    /// Duty times ticks \[2^-30\] that a step of travel takes against the motor's own voltage \[2^-8\].
    pub speed_cost: i64,
    /// Duty times ticks \[2^-30\] that a speed of one step of travel per tick takes.
    pub acceleration_cost: i64,
    /// Duty times looks that takes a wheel four counts far, slowly \[2^-18\].
    pub push_max: i32,
    /// A wheel is pushed by a duty above this \[2^-30\].
    pub push_duty: i32,
    pub resting_error: i32,
    /// So far off its place the loop drives a wheel back at rest.
    pub rest_band: u32,
    pub resting_duty: i32,
    pub quiet: QuietBounds,
}

/// Within these a wheel [is quiet](super::wheel_monitor::WheelMonitor).
#[derive(Clone, Copy, Debug)]
pub(super) struct QuietBounds {
    /// Error while the setpoint moves, below this \[2^-30 m\].
    pub error: u32,
    /// Error while it rests, below this \[2^-30 m\].
    pub resting_error: u32,
    /// Advance of the setpoint since the last count, at most this \[2^-24 m\].
    pub advance: u32,
}

impl QuietBounds {
    fn new(error: i32, resting_error: i32, advance: i32) -> Self {
        // A wheel that only just is not quiet is looked at: nothing is rounded up.
        let fine = |steps: i32| {
            saturate_i32(i64::from(steps) << (I2F30::FRAC_NBITS - POSITION_BITS)) as u32
        };
        Self {
            error: fine(error),
            resting_error: fine(resting_error),
            advance: (advance - 1) as u32,
        }
    }
}

impl WheelThresholds {
    #[inline]
    fn new(config: &Config, wheel: Wheel, q: MetersPerCount) -> Self {
        let q_m = q.metres();
        let hz = f64::from(CONTROL_HZ);
        let steps = |m: f64| saturate_i32(truncate(m, POSITION_BITS));
        let error_m_max = config.protection.following_error_m_max;
        let [ks_forward, ks_backward, kv, ka] = config.feedforward.shares(wheel);
        let ks = max(ks_forward, ks_backward);
        // Of a step of travel in a duty of 2^-30.
        let share = hz * f64::from(1 << (I2F30::FRAC_NBITS - POSITION_BITS));
        let error_max = steps(error_m_max);
        let four_counts = steps(4.0 * q_m);
        let three_counts = (four_counts >> 2) * 3;
        let six_counts = (2 * three_counts).min(three_counts.max(error_max / 4));
        let (count, least_advance) = (four_counts >> 2, steps(0.002));
        let rest_band = count.max(steps(REST_BAND_M));
        // A long count takes longer, and what pushes it that long may be friction.
        let pushing = if four_counts > least_advance { 10 } else { 20 };
        let standing_advance = four_counts.max(least_advance);
        let friction = nearest(ks, I2F30::FRAC_NBITS);
        let speed_cost = nearest(kv * share, 8);
        let stall_ticks = (truncate(config.protection.stall_time_s * hz, 0) as u32).max(1);
        Self {
            error_max,
            counts_per_tick_max: saturate_i32(counts_per_tick_max(config, q) as i64) as u32,
            stall_ticks,
            checkpoint_ticks: (stall_ticks + (CHECKPOINTS_LEN as u32 - 1))
                >> CHECKPOINTS_LEN.ilog2(),
            standing_advance,
            creeping_advance: 2 * standing_advance,
            reversed_run: six_counts.max(error_max / 20 * 3),
            runaway: six_counts.max(error_max / 20),
            friction,
            speed_cost,
            acceleration_cost: nearest(ka * (share * hz), 0),
            push_max: saturate_i32((speed_cost * i64::from(four_counts)) >> (9 + PUSH_SHIFT)),
            push_duty: friction as i32 + (1 << I2F30::FRAC_NBITS) / pushing,
            resting_error: four_counts,
            rest_band: rest_band as u32,
            resting_duty: friction as i32 + (1 << I2F30::FRAC_NBITS) / 10,
            quiet: QuietBounds::new(
                error_max.min(least_advance.max(count)),
                rest_band,
                (least_advance >> 2).max(count),
            ),
        }
    }
}

impl WheelThresholds {
    /// A count is shorter than 1 mm: the loop does not drive a sound wheel to and fro across an edge.
    pub fn counts_are_short(&self) -> bool {
        self.resting_error < 1 << (POSITION_BITS - 8)
    }

    /// Duty times ticks that takes a wheel so far, from a speed \[2^-24 m/tick\] to that of so much travel in so many
    /// ticks \[2^-30\].
    pub fn needed(&self, way: u32, (turned, ticks): (u32, u32), from: i32) -> i64 {
        let gained = (turned / ticks.max(1)) as i32 - from;
        ((self.speed_cost * i64::from(way)) >> 8) + self.acceleration_cost * i64::from(gained)
    }
}

/// A count that changes in one tick by more than this is faster than the wheel can turn.
#[inline]
pub fn counts_per_tick_max(config: &Config, q: MetersPerCount) -> u64 {
    let speed_mps_max = max(config.limits.speed_mps_max, 0.1);
    4 + truncate(speed_mps_max * (4.0 / f64::from(CONTROL_HZ)) / q.metres(), 0) as u64
}
