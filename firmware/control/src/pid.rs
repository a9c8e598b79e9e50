//! The travel controller of one wheel: feedforward, and PID on travel.
//!
//! # Equations
//!
//! With the setpoint's travel s, speed v and acceleration a, the measured s_m and v_m, and e = s - s_m:
//!
//! ```text
//! u_ff = (kS sign(v) + kV v + kA a) / U_nominal                                 (1)  kS by direction
//! u_p  = kp e                                                                   (2)
//! u_i  = sum of ki e dt, within +-duty_max, not driven further into a limit;
//!        while |v| < 3.9 mm/s, only of e of a count and 0.25 mm, or more        (3)
//! u_d  = kd (v_r - v_m) + kd T a,   v_r' = (v - v_r) / T                        (4)
//! u    = g (u_ff + u_p + u_i + u_d), within +-duty_max, changing by duty_slew dt at most    (5)
//! ```
//!
//! The measured speed is the mean over a window of 40 ms ([`crate::encoder`]). Compared with v itself, it would look too slow
//! for as long as that after each beginning of an acceleration, and swing the wheel; so v goes through a like lag, T = 16 ms:
//! the sum of v_m - v_r over time is then zero. kd T a belongs to the feedforward: with it, kA is what it would be without the lag.
//!
//! A wheel that stands within a count of its place stays there. The sum of so small an error would grow until it turns the
//! wheel, and for ever if the encoder is dead.
//!
//! The terms are shares of the nominal supply, and g is the nominal over the measured supply
//! ([`crate::supply`]); u is a share of the supply at hand. Forward is positive everywhere. A tick uses the sum (3)
//! up to the tick before. Ranges and steps:
//!
//! | quantity | range | step |
//! | --- | --- | --- |
//! | e | 2 m, saturated | 2^-30 m |
//! | kp | 10^4 /m | 2^-14 /m |
//! | ki dt | 10 /m | 2^-27 /m |
//! | kV / U_nominal, kd | 1000 s/m | 2^-20 s/m |
//! | kA / U_nominal | 100 s^2/m | 2^-20 s^2/m |
//!
//! Products are 32 by 32 bits into 64. They are added with 44 fractional bits, which all but the integral have by
//! themselves. The sum is below 2^19, whatever the gains, so that large terms of opposite sign cancel correctly. The
//! integral's limit is rounded down to a step of 2^-25. Telemetry's units are made outside the tick.

use fixed::types::I2F30;
use shared_proto::{Config, PidTerms, Wheel, WheelPair};

use crate::odometry::Odometry;
use crate::profile::Setpoint;
use crate::soft_float::{max, min, nearest};
use crate::supply::SCALE_BITS;
use crate::units::{CONTROL_HZ, Duty, Speed, Travel, duty_bits_to_i16, saturate_i32};

/// Fractional bits of the terms' sum. 10^4 /m x 2 m + 1000 s/m x (128 + 256) m/s +
/// 100 s^2/m x 128 m/s^2 + 2 is below 2^19, which leaves 44 bits of 63.
const TERM_BITS: u32 = 44;
/// Largest kV as a share of the nominal supply \[s/m\].
const KV_MAX: f64 = 1000.0;
/// Largest kA as a share of the nominal supply \[s^2/m\].
const KA_MAX: f64 = 100.0;
/// So near its place a wheel may stand, where a count is shorter \[m\].
pub(crate) const REST_BAND_M: f64 = 0.25e-3;
/// A setpoint that is slower than 3.9 mm/s rests, or trembles about rest as a stick does: the bits of a lower speed
/// \[2^-24 m/s\].
const REST_SPEED_BITS: u32 = 16;
/// Fractional bits of kp.
const KP_BITS: u32 = TERM_BITS - ERROR_BITS;
/// Fractional bits of ki dt.
const KI_BITS: u32 = 27;
/// Fractional bits of kv and kd.
const KV_BITS: u32 = TERM_BITS - SPEED_BITS;
/// Fractional bits of ka.
const KA_BITS: u32 = TERM_BITS - SPEED_BITS;
/// T in ticks, in bits.
const LAG_TICKS_BITS: u32 = 4;
/// Fractional bits of T in seconds, and T.
const LAG_BITS: u32 = 20;
const LAG_S: i32 = (1 << (LAG_BITS + LAG_TICKS_BITS)) / CONTROL_HZ as i32;
/// Fractional bits of a duty.
const DUTY_BITS: u32 = 30;
/// Fractional bits of a travel error.
const ERROR_BITS: u32 = 30;
/// Fractional bits of speeds and accelerations.
const SPEED_BITS: u32 = 24;
/// Fractional bits of the integral: those of ki dt times an error, so that no sum is rounded.
const INTEGRAL_BITS: u32 = KI_BITS + ERROR_BITS;

/// One wheel's gains and limits.
#[derive(Clone, Copy, Debug)]
pub struct Gains {
    /// In the terms' steps, as the sum begins with it.
    ks_forward: i64,
    /// Below zero.
    ks_backward: i64,
    kv: i32,
    /// With kd T.
    ka: i32,
    kp: i32,
    ki_dt: i32,
    kd: i32,
    duty_max: i32,
    duty_slew_dt: i32,
    /// At rest, or nearly, an error below this is not summed \[2^-30 m\].
    rest_band: u32,
}

impl Gains {
    /// One wheel's gains, of a valid configuration.
    #[inline]
    pub fn new(config: &Config, wheel: Wheel) -> Self {
        let dt_s = 1.0 / f64::from(CONTROL_HZ);
        let (pid, limits) = (&config.pid, &config.limits);
        let [ks_forward, ks_backward, kv, ka] = config.feedforward.shares(wheel);
        let ks = |share: f64| i64::from(scaled(share, DUTY_BITS)) << (TERM_BITS - DUTY_BITS);
        let kd = scaled(pid.kd_s_per_m, KV_BITS);
        let q_m = Odometry::new(config).meters_per_count().get(wheel).metres();
        Self {
            ks_forward: ks(ks_forward),
            ks_backward: -ks(ks_backward),
            kv: scaled(min(kv, KV_MAX), KV_BITS),
            // Below 100 s^2/m + 16 s^2/m.
            ka: scaled(min(ka, KA_MAX), KA_BITS) + (product(kd, LAG_S) >> LAG_BITS) as i32,
            kp: scaled(pid.kp_per_m, KP_BITS),
            ki_dt: scaled(pid.ki_per_m_s * dt_s, KI_BITS),
            kd,
            duty_max: scaled(limits.duty_max, DUTY_BITS),
            duty_slew_dt: scaled(limits.duty_slew_per_s * dt_s, DUTY_BITS),
            rest_band: scaled(max(q_m, REST_BAND_M), ERROR_BITS) as u32,
        }
    }

    /// The largest duty.
    pub const fn duty_max(&self) -> Duty {
        Duty(I2F30::from_bits(self.duty_max))
    }

    /// A duty for the nominal supply at the supply at hand, within +-duty_max; `supply_scale` as in [`step_both`].
    #[inline(never)]
    pub fn at_supply(&self, duty: Duty, supply_scale: i32) -> Duty {
        let wanted =
            saturate_i32((i64::from(duty.0.to_bits()) * i64::from(supply_scale)) >> SCALE_BITS);
        Duty(I2F30::from_bits(wanted.max(-self.duty_max).min(self.duty_max)))
    }
}

/// A gain, not negative, to the nearest step; saturates.
#[inline(never)]
fn scaled(value: f64, fractional_bits: u32) -> i32 {
    saturate_i32(nearest(value, fractional_bits))
}

/// The controller's state; the sums keep the terms for telemetry, in steps of 2^-44.
#[derive(Clone, Copy, Debug, Default)]
pub struct PidState {
    feedforward: i64,
    /// And with u_p, and with u_d.
    with_proportional: i64,
    with_derivative: i64,
    /// In steps of 2^-57.
    integral: i64,
    /// The integral that the last tick used, in steps of 2^-57.
    integral_used: i64,
    duty: i32,
    /// v_r, in steps of 2^-24 m/s.
    reference: i32,
    /// e, in steps of 2^-30 m.
    error: i32,
}

impl PidState {
    /// The state before the first tick.
    pub const ZERO: Self = Self {
        feedforward: 0,
        with_proportional: 0,
        with_derivative: 0,
        integral: 0,
        integral_used: 0,
        duty: 0,
        reference: 0,
        error: 0,
    };

    /// The terms of the last tick.
    #[inline]
    pub fn terms(&self) -> PidTerms {
        let term = |bits: i64| duty_bits_to_i16(bits >> (TERM_BITS - DUTY_BITS));
        PidTerms {
            feedforward: term(self.feedforward),
            proportional: term(self.with_proportional - self.feedforward),
            integral: duty_bits_to_i16(self.integral_used >> (INTEGRAL_BITS - DUTY_BITS)),
            derivative: term(self.with_derivative - self.with_proportional),
        }
    }

    /// The error of the last tick, e \[m\].
    pub const fn error(&self) -> I2F30 {
        I2F30::from_bits(self.error)
    }

    /// The integral that the last tick used, as a duty at the nominal supply.
    pub const fn integral(&self) -> i32 {
        (self.integral_used >> (INTEGRAL_BITS - DUTY_BITS)) as i32
    }

    /// Whether the error of the last tick was at most this \[m\].
    #[inline(always)]
    pub const fn is_within(&self, most: I2F30) -> bool {
        self.error.unsigned_abs() <= most.to_bits() as u32
    }

    /// The duty of the last tick.
    pub const fn duty(&self) -> Duty {
        Duty(I2F30::from_bits(self.duty))
    }
}

/// One tick of both wheels' controllers; `supply_scale` is g, with [`SCALE_BITS`] fractional bits.
#[inline(never)]
pub fn step_both(
    gains: &WheelPair<Gains>,
    states: &mut WheelPair<PidState>,
    setpoints: &WheelPair<Setpoint>,
    travel: &WheelPair<Travel>,
    speed: &WheelPair<Speed>,
    supply_scale: i32,
) -> WheelPair<Duty> {
    WheelPair {
        left: step(
            &gains.left,
            &mut states.left,
            &setpoints.left,
            travel.left,
            speed.left,
            supply_scale,
        ),
        right: step(
            &gains.right,
            &mut states.right,
            &setpoints.right,
            travel.right,
            speed.right,
            supply_scale,
        ),
    }
}

/// One tick of a wheel's controller.
#[inline(always)]
pub fn step(
    gains: &Gains,
    state: &mut PidState,
    setpoint: &Setpoint,
    travel: Travel,
    speed: Speed,
    supply_scale: i32,
) -> Duty {
    let error = setpoint.travel.error_from(travel).to_bits();
    let (v, v_measured) = (setpoint.speed.0.to_bits(), speed.0.to_bits());
    // (4)
    let speed_error = state.reference.saturating_sub(v_measured);
    state.reference += v.saturating_sub(state.reference) >> LAG_TICKS_BITS;

    // (1)
    let ks = match v {
        0 => 0,
        1.. => gains.ks_forward,
        _ => gains.ks_backward,
    };
    let feedforward =
        ks + product(gains.kv, v) + product(gains.ka, setpoint.acceleration.0.to_bits());
    // (3)
    let unseen = nearly_rests(v) && error.unsigned_abs() < gains.rest_band;
    let summed = if unseen { 0 } else { error };
    // (2)
    let with_proportional = feedforward + product(gains.kp, error);
    // (4)
    let with_derivative = with_proportional + product(gains.kd, speed_error);
    let integral = state.integral;
    state.error = error;
    state.feedforward = feedforward;
    (state.with_proportional, state.with_derivative) = (with_proportional, with_derivative);
    state.integral_used = integral;

    // (5)
    let sum = with_derivative + (integral >> (INTEGRAL_BITS - TERM_BITS));
    let nominal = saturate_i32(sum >> (TERM_BITS - DUTY_BITS));
    let wanted = saturate_i32(product(nominal, supply_scale) >> SCALE_BITS);
    let lowest = state.duty.saturating_sub(gains.duty_slew_dt).max(-gains.duty_max);
    let highest = state.duty.saturating_add(gains.duty_slew_dt).min(gains.duty_max);
    state.duty = wanted.max(lowest).min(highest);

    // (3)
    let into_limit = (wanted > highest && summed > 0) || (wanted < lowest && summed < 0);
    if !into_limit {
        // Both limits are whole steps of the upper word.
        let bound = gains.duty_max >> (DUTY_BITS + 32 - INTEGRAL_BITS);
        let integral = integral + product(gains.ki_dt, summed);
        let upper = (integral >> 32) as i32;
        state.integral = if upper >= bound {
            i64::from(bound) << 32
        } else if upper < -bound {
            i64::from(-bound) << 32
        } else {
            integral
        };
    }
    state.duty()
}

/// Whether a setpoint of this speed \[2^-24 m/s\] rests, or nearly.
#[inline(always)]
pub(crate) const fn nearly_rests(v: i32) -> bool {
    v.wrapping_add(1 << REST_SPEED_BITS) >> (REST_SPEED_BITS + 1) == 0
}

fn product(a: i32, b: i32) -> i64 {
    i64::from(a) * i64::from(b)
}
