//! The check of one wheel: a push that ends as soon as the count tells enough.

use fixed::types::I2F30;
use shared_proto::{Config, Fault, Wheel};

use crate::protection::counts_per_tick_max;
use crate::soft_float::{max, min, nearest, truncate};
use crate::units::{CONTROL_HZ, Duty, MetersPerCount};

/// Time for the duty to rise from zero to the largest, at first.
const RISE_TICKS: i32 = 8 * CONTROL_HZ as i32 / 10;
/// The same once a robot with the model's friction would have passed.
const FAST_RISE_TICKS: i32 = CONTROL_HZ as i32 / 50;
/// The largest duty is held for this many stall times before the probe gives up.
const HOLD_STALL_TIMES: f64 = 7.0;
/// Expected travel (1) at which the push ends \[m\]: of the 10 mm that a robot with an unplugged encoder
/// may move, the rest being for rolling out and a weak model.
const EXPECTED_M_MAX: f64 = 0.0068;
/// A coarse encoder is allowed the distance of this many counts, if that is longer.
const EXPECTED_COUNTS_MAX: f64 = 6.0;
/// The share of that travel which is pushed slowly.
const SLOW_SHARE: i64 = 5;
/// Counts that tell a direction; of counts so long that three of them are more than [`TRAVEL_M_ENOUGH`], the fewer.
const COUNTS_MIN: u32 = 3;
const LONG_COUNTS_MIN: u32 = 2;
/// Travel that tells a direction for certain \[m\].
const TRAVEL_M_ENOUGH: f64 = 0.002;
/// The share of that which is taken against the backlash and shiver that fine encoders see.
const FINE_SHARE: u32 = 10;
/// The share of it that is taken against a wheel that the push of the other one rolls a little.
const OTHERS_SHARE: u32 = 3;
/// A count that has moved the wrong way is called reversed after this long \[ticks\]: interference that began within a tick,
/// and so looked slow, is known for what it is by then.
const AGAINST_TICKS: u32 = 3;
/// Changes of the count that tell a movement from one loose edge.
const CHANGES_MIN: u32 = 2;
/// Changes that tell a line that is cut from a wheel that is blocked. With one line left an encoder on a turning
/// wheel counts up and down; so does one whose line floats.
const CHANGES_OF_ONE_LINE: u32 = 3;
/// The other wheel's count moves at most this many times [`COUNTS_MIN`] before it is looked at; more is
/// interference.
const OTHER_TIMES_MAX: i32 = 4;
/// After the push the wheel may roll this long before the verdict, and three time constants more \[ticks\].
const ROLL_TICKS: u32 = 40;
/// Those three at most \[ticks\].
const ROLL_TICKS_MAX: f64 = 1000.0;
/// A wheel stands whose count does not change for this long \[s\],
const QUIET_S: f64 = 0.02;
/// and which is slower than this \[m/s\]: long counts change seldom.
const STANDS_MPS: f64 = 0.0125;
/// Fractional bits of a lag.
const LAG_BITS: u32 = 16;
/// Fractional bits of a time constant in ticks.
const TIME_CONSTANT_BITS: u32 = 8;
/// Fractional bits of an inverse of a duty in steps of 2^-30.
const PER_KS_BITS: u32 = 46;
/// Fractional bits of a duty's share in another.
const SHARE_BITS: u32 = 16;
/// No wheel of a robot rolls faster at full duty \[m/s\]; bounds (1) where kv is not configured.
const FULL_SPEED_MPS_MAX: f64 = 20.0;

/// The limits of one wheel's check.
#[derive(Clone, Copy, Debug)]
pub(super) struct PushLimits {
    duty_max: i32,
    ks: i32,
    /// Of (1) and (2), as a sum of duties over ticks [2^-30].
    push_max: i64,
    /// Up to here the push is slow.
    push_slow: i64,
    /// A tick over the time constant kA / kV, at most 1 [2^-16].
    lag: i64,
    /// Its inverse [ticks, 2^-8].
    time_constant: i64,
    /// 1 / (2 kS), duties in steps of 2^-30 [2^-46]. Here, so that no tick divides.
    per_twice_ks: i64,
    hold_ticks: u32,
    /// So long the wheel may roll out.
    roll_ticks: u32,
    counts: i32,
    /// Of the other wheel, that tell that it is this one.
    pub other_counts: i32,
    /// A wheel whose count has not changed for so long stands.
    pub quiet_ticks: u32,
    counts_per_tick_max: u32,
}

impl PushLimits {
    /// Of this wheel, pushed forwards if `sign` is positive.
    #[inline(never)]
    pub fn new(config: &Config, wheel: Wheel, sign: i32, q: MetersPerCount) -> Self {
        let q_m = q.metres();
        let hz = f64::from(CONTROL_HZ);
        let bits = |duty: f64| nearest(duty, I2F30::FRAC_NBITS) as i32;
        let [ks_forward, ks_backward, kv, ka] = config.feedforward.shares(wheel);
        let ks = if sign < 0 { ks_backward } else { ks_forward };
        let kv_s_per_m = max(kv, 1.0 / FULL_SPEED_MPS_MAX);
        let constant_ticks = ka / kv_s_per_m * hz;
        let expected_m = max(EXPECTED_M_MAX, EXPECTED_COUNTS_MAX * q_m);
        let push_max = truncate(expected_m * kv_s_per_m * hz, I2F30::FRAC_NBITS);
        let lag =
            truncate(min(1.0, 1.0 / max(constant_ticks, 1.0 / ROLL_TICKS_MAX)), LAG_BITS).max(1);
        let ks = bits(min(ks, 1.0));
        let enough = truncate(TRAVEL_M_ENOUGH / q_m, 0) as u32;
        Self {
            duty_max: bits(min(config.protection.probe_duty_max, config.limits.duty_max)),
            ks,
            push_max,
            push_slow: push_max / SLOW_SHARE,
            lag,
            time_constant: (1 << (LAG_BITS + TIME_CONSTANT_BITS)) / lag,
            per_twice_ks: (1 << PER_KS_BITS) / (2 * i64::from(ks)).max(1 << 10),
            roll_ticks: ROLL_TICKS + truncate(min(3.0 * constant_ticks, ROLL_TICKS_MAX), 0) as u32,
            hold_ticks: truncate(config.protection.stall_time_s * (HOLD_STALL_TIMES * hz), 0)
                as u32,
            other_counts: COUNTS_MIN.max(enough / OTHERS_SHARE) as i32,
            counts: enough.clamp(LONG_COUNTS_MIN, COUNTS_MIN).max(enough / FINE_SHARE) as i32,
            quiet_ticks: truncate(max(QUIET_S, q_m / STANDS_MPS) * hz, 0) as u32,
            counts_per_tick_max: counts_per_tick_max(config, q) as u32,
        }
    }
}

/// Looks for a count that changes faster than its wheel can turn. One such change may be one loose edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct RateWatch {
    max: u32,
    last: i32,
    too_fast: u32,
}

impl RateWatch {
    pub fn new(limits: PushLimits, count: i32) -> Self {
        Self { max: limits.counts_per_tick_max, last: count, too_fast: 0 }
    }

    /// Looks at the count of one tick. How far it jumped, if no wheel turns so fast; 0 otherwise.
    pub fn jump(&mut self, count: i32) -> i32 {
        let moved = count.wrapping_sub(core::mem::replace(&mut self.last, count));
        if moved.unsigned_abs() <= self.max {
            return 0;
        }
        self.too_fast += 1;
        moved
    }

    /// Whether the count jumped so often that it is interference.
    pub fn is_too_fast(&self) -> bool {
        self.too_fast >= CHANGES_MIN
    }
}

/// A count that is watched from a start.
#[derive(Clone, Copy, Debug)]
struct Watched {
    start: i32,
    last: i32,
    changes: u32,
    /// The lowest and the highest.
    range: (i32, i32),
}

impl Watched {
    fn new(count: i32) -> Self {
        Self { start: count, last: count, changes: 0, range: (count, count) }
    }

    /// How far the count has moved, once it has changed often enough.
    fn moved(&mut self, count: i32) -> i32 {
        if count != self.last {
            self.last = count;
            self.changes = self.changes.saturating_add(1);
            self.range = (self.range.0.min(count), self.range.1.max(count));
        }
        if self.changes < CHANGES_MIN { 0 } else { count.wrapping_sub(self.start) }
    }
}

impl Watched {
    /// The count jumped: what it is watched for began as much farther on.
    fn shift(&mut self, jump: i32) {
        for place in [&mut self.start, &mut self.last, &mut self.range.0, &mut self.range.1] {
            *place = place.wrapping_add(jump);
        }
    }

    /// Whether the count mostly goes up and down.
    fn is_of_one_line(&self) -> bool {
        let (lowest, highest) = self.range;
        let wide = highest.wrapping_sub(lowest).saturating_mul(2) >= self.changes as i32;
        self.changes >= CHANGES_OF_ONE_LINE && !wide
    }
}

/// What one tick of a push told.
pub(super) enum Push {
    /// Not enough; apply this duty.
    Running(Duty),
    /// The count moves the way the motor pushes.
    Passed,
    /// The fault, for this wheel.
    Failed(fn(Wheel) -> Fault),
}

/// The state of one wheel's check.
#[derive(Clone, Copy, Debug)]
pub(super) struct WheelProbe {
    /// 1 or -1.
    sign: i32,
    own: Watched,
    other: Watched,
    /// Counts that tell that the other wheel's count moves.
    other_counts: i32,
    duty: i32,
    /// The sum in (1) so far.
    push: i64,
    /// The lagging duty in (2).
    lagging: i64,
    held_ticks: u32,
    /// The count has moved the wrong way for so long.
    against_ticks: u32,
    /// The push is over, and the wheel rolls for this many ticks more.
    rolling: Option<u32>,
}

impl WheelProbe {
    pub fn new(limits: &PushLimits, sign: i32, own: i32, other: i32, other_counts: i32) -> Self {
        Self {
            sign,
            own: Watched::new(own),
            other: Watched::new(other),
            other_counts,
            // Below the model's friction nothing moves.
            duty: (limits.ks / 2).min(limits.duty_max),
            push: 0,
            lagging: 0,
            held_ticks: 0,
            against_ticks: 0,
            rolling: None,
        }
    }

    /// The counts jumped, the wheel's own and the other wheel's: no wheel rolled so far.
    #[cold]
    pub fn shift(&mut self, own: i32, other: i32) {
        self.own.shift(own);
        self.other.shift(other);
    }

    /// One tick, with the wheel's own count and the other wheel's.
    pub fn step(&mut self, limits: &PushLimits, own: i32, other: i32) -> Push {
        let moved = self.own.moved(own).wrapping_mul(self.sign);
        if moved >= limits.counts && !self.own.is_of_one_line() {
            return Push::Passed;
        }
        let against = moved <= -limits.counts && !self.own.is_of_one_line();
        self.against_ticks = if against { self.against_ticks + 1 } else { 0 };
        if self.against_ticks >= AGAINST_TICKS {
            return Push::Failed(Fault::EncoderReversed);
        }
        if self.push == 0 {
            // Whatever the other wheel does before the push is not its effect.
            self.other = Watched::new(other);
        }
        let others = self.other.moved(other).saturating_abs();
        let range = self.other_counts..=OTHER_TIMES_MAX * self.other_counts;
        let exchanged = range.contains(&others) && !self.other.is_of_one_line();
        if self.own.changes < CHANGES_MIN && exchanged {
            return Push::Failed(Fault::EncodersExchanged);
        }
        match &mut self.rolling {
            Some(0) if self.own.is_of_one_line() => Push::Failed(Fault::EncoderDead),
            Some(0) => Push::Failed(Fault::NoResponse),
            Some(left) => {
                *left -= 1;
                Push::Running(Duty::ZERO)
            }
            None => Push::Running(self.push_on(limits)),
        }
    }

    /// What the wheel rolls on without a push, as (1): with T = kA / kV and the speed v = w / kV at most v T, as the
    /// motor brakes, and at most v^2 kA / (2 kS), as friction does.
    fn rolls_on(&self, limits: &PushLimits) -> i64 {
        let Self { lagging, .. } = self;
        // Below 2^47: the duty is 2^30 at most, and the time constant 2^16 ticks. Below, the product is below 2^62.
        let by_motor = (lagging * limits.time_constant) >> TIME_CONSTANT_BITS;
        if *lagging >= 2 * i64::from(limits.ks) {
            return by_motor;
        }
        let share = (lagging * limits.per_twice_ks) >> (PER_KS_BITS - SHARE_BITS);
        (by_motor * share) >> SHARE_BITS
    }

    /// The duty of this tick.
    fn push_on(&mut self, limits: &PushLimits) -> Duty {
        // (2), with the duty of the tick before, and (1)
        let excess = i64::from((self.duty - limits.ks).max(0));
        self.lagging += ((excess - self.lagging) * limits.lag) >> LAG_BITS;
        self.push += self.lagging;
        if self.duty < limits.duty_max {
            let slow = self.push < limits.push_slow;
            let rise_ticks = if slow { RISE_TICKS } else { FAST_RISE_TICKS };
            let rise = (limits.duty_max / rise_ticks).max(1);
            self.duty = (self.duty + rise).min(limits.duty_max);
        } else {
            self.held_ticks += 1;
        }
        if self.push + self.rolls_on(limits) > limits.push_max
            || self.held_ticks >= limits.hold_ticks
        {
            self.rolling = Some(limits.roll_ticks);
            return Duty::ZERO;
        }
        Duty(I2F30::from_bits(self.duty * self.sign))
    }
}
