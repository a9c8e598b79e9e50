//! Travel of the wheels from their encoder counts: the one place that knows W_T.
//!
//! # Equations
//!
//! ```text
//! Q    = 2 pi R_L / (N * reduction)      distance per count of a wheel of radius R_L     (1), the paper's (3-1)
//! dS_L = C_L * Q_L                       travel of the left wheel                        (2)
//! dS_R = C_R * Q_R * W_T                 travel of the right wheel, W_T = R_R / R_L      (3), the paper's (3-5)
//! ```
//!
//! | symbol | meaning | type |
//! | --- | --- | --- |
//! | Q | distance per count \[m\], 1 um to 0.1 m | 64 fractional bits |
//! | W_T | wheel weight, 0.8 to 1.25 | 62 fractional bits, steps of 2e-19 |
//! | C | absolute count, forward positive | `i64` |
//! | dS | travel \[m\], forward positive | 32 fractional bits |
//!
//! Travel always comes from the absolute count, so nothing accumulates. The step of Q * W_T
//! contributes at most C * 2^-64 m: 10 km at 1 um per count are wrong by 0.5 nm.

use fixed::types::{I32F32, U0F64, U2F62};
use shared_proto::{Config, EncoderConfig, WheelPair};

use crate::soft_float::nearest;
use crate::units::{MetersPerCount, Travel};

/// Turns counts into travel.
#[derive(Clone, Copy, Debug)]
pub struct Odometry {
    /// Q of the left wheel and Q * W_T of the right one.
    meters_per_count: WheelPair<MetersPerCount>,
}

impl Odometry {
    /// The odometry of a valid configuration.
    #[inline]
    pub fn new(config: &Config) -> Self {
        // (1)
        // Both fit: Q is 0.1 m at most, and W_T 1.25.
        let bits = |value, bits| nearest(value, bits) as u64;
        let nominal = |encoder: &EncoderConfig| {
            U0F64::from_bits(bits(config.meters_per_count(encoder), U0F64::FRAC_NBITS))
        };
        let wheel_weight = bits(config.geometry.wheel_weight, U2F62::FRAC_NBITS);
        let wheel_weight = U2F62::from_bits(wheel_weight);
        Self {
            meters_per_count: WheelPair::new(
                MetersPerCount(nominal(&config.encoder.left)),
                MetersPerCount(weigh(nominal(&config.encoder.right), wheel_weight)),
            ),
        }
    }

    /// Distance per count of each wheel; the right wheel's includes W_T.
    pub const fn meters_per_count(&self) -> WheelPair<MetersPerCount> {
        self.meters_per_count
    }

    /// Travel of each wheel from its absolute count. Valid to 2^31 m either way; wraps beyond.
    pub fn travel(&self, counts: WheelPair<i64>) -> WheelPair<Travel> {
        // (2), (3)
        counts.zip(self.meters_per_count).map(|(counts, q)| rolled(counts, q))
    }
}

/// Q * W_T to the nearest 2^-64 m.
#[inline]
fn weigh(q: U0F64, wheel_weight: U2F62) -> U0F64 {
    let product = u128::from(q.to_bits()) * u128::from(wheel_weight.to_bits());
    U0F64::from_bits(((product + (1 << 61)) >> 62) as u64)
}

/// C * Q: the exact product, rounded once to the nearest 2^-32 m.
///
/// In four 32-bit products, which is what a Cortex-M4 has; 128-bit arithmetic would call a
/// library function.
#[inline(always)]
fn rolled(counts: i64, MetersPerCount(q): MetersPerCount) -> Travel {
    let (counts_high, counts_low) = ((counts >> 32) as i32, counts as u32);
    let (q_high, q_low) = ((q.to_bits() >> 32) as u32, q.to_bits() as u32);
    let wide = |a: u32, b: u32| u64::from(a) * u64::from(b);
    let lowest = wide(counts_low, q_low);
    // To the nearest: what is cut off is half a step or more where its highest bit is set.
    let lowest = (lowest >> 32) as u32 + (lowest as u32 >> 31);
    // (2^32 - 1)^2 + 2^32 is below 2^64: no sum overflows, nor does that above.
    let middle = wide(counts_low, q_high) + u64::from(lowest);
    // Of the upper half of the counts, which is below zero for all that are, what is left within 64 bits.
    let high = i64::from(counts_high).wrapping_mul(i64::from(q_low));
    let highest = counts_high.wrapping_mul(q_high as i32);
    let bits = (middle as i64).wrapping_add(high).wrapping_add(i64::from(highest) << 32);
    Travel(I32F32::from_bits(bits))
}
