//! The shape of one wheel's motion in continuous time: ramp to cruise, cruise, ramp to zero.
//!
//! # Equations
//!
//! In the frame where the wheel has to go forward from braking at once (mirrored where it has to
//! go backward), with distance d, initial velocity v0, acceleration a = 2 h and cruise velocity vc:
//!
//! ```text
//! t1 = |vc - v0| / a,   t2 = t1 + tc,   t3 = t2 + vc / a                                  (1)
//! d  = (vc^2 - v0^2) / (2 a sign(vc - v0)) + vc tc + vc^2 / (2 a)                         (2)
//! vc = sqrt(a d + v0^2 / 2)                              where tc = 0                      (3)
//! d  = v0^2 / (2 a) + vc (t3 - v0 / a)                   vc <= v0, duration t3 given       (4)
//! d  = vc t3 - (vc^2 + (vc - v0)^2) / (2 a)              vc >= v0, duration t3 given       (5)
//! ```
//!
//! (5) is concave in vc with slope tc, so Newton's steps from below approach its root from below.
//! Units: 2^-64 m, 2^-64 m per tick, 2^-64 m per tick^2, times in 2^-32 ticks. Products of two
//! velocities need 118 bits, a velocity times a duration 122.

use super::course::{Course, Phase};
use crate::wide::{div, mul, sqrt};

/// Steps per tick in which phase boundaries are placed.
pub(super) const TICK_BITS: u32 = 32;

/// What one wheel has to do, and what it may use for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task {
    /// Signed distance [2^-64 m].
    pub distance: i128,
    /// Initial velocity [2^-64 m/tick].
    pub velocity: i64,
    /// Half the acceleration, above zero [2^-64 m/tick^2].
    pub half: i64,
    /// Cruise speed, above zero [2^-64 m/tick].
    pub cruise: i64,
}

/// A wheel's motion; `distance`, `velocity`, `cruise` in the frame that `mirrored` tells.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ramps {
    mirrored: bool,
    distance: i128,
    velocity: i64,
    half: i64,
    cruise: i64,
    /// End of the first ramp, of the cruise, and of the last ramp [2^-32 ticks].
    ends: [i128; 3],
}

impl Ramps {
    /// The quickest motion within the limits.
    #[inline]
    pub fn quickest(task: Task) -> Self {
        let four_half = 4 * i128::from(task.half);
        let braking = div(mul(task.velocity.into(), task.velocity.abs().into()), four_half);
        let mirrored = task.distance < braking;
        let distance = mirror(task.distance, mirrored);
        let velocity = if mirrored { -task.velocity } else { task.velocity };
        let (v0_squared, limit_squared) = (square(velocity), square(task.cruise));
        let cruise = if velocity >= task.cruise
            || distance >= div(2 * limit_squared - v0_squared, four_half)
        {
            task.cruise
        } else {
            // (3)
            let squared = mul(2 * i128::from(task.half), distance) + v0_squared / 2;
            (sqrt(squared.max(0)) as i64).clamp(velocity.max(0), task.cruise)
        };
        let mut ramps =
            Self { mirrored, distance, velocity, half: task.half, cruise, ends: [0; 3] };
        // (2)
        let gain = div(square(cruise) - v0_squared, four_half);
        let first = if cruise >= velocity { gain } else { -gain };
        let cruised = (distance - first - div(square(cruise), four_half)).max(0);
        let cruise_time = if cruise > 0 { div(cruised << TICK_BITS, cruise.into()) } else { 0 };
        // (1)
        let first_ramp = ramps.ramp_time(cruise.abs_diff(velocity));
        let last_ramp = ramps.ramp_time(cruise.unsigned_abs());
        ramps.ends = [first_ramp, first_ramp + cruise_time, first_ramp + cruise_time + last_ramp];
        ramps
    }

    /// The same distance in a longer time, by a lower cruise speed.
    #[inline]
    pub fn stretched(self, duration: i128) -> Self {
        if duration <= self.duration() {
            return self;
        }
        let cruise = self.stretched_cruise(duration);
        let mut ramps = Self { cruise, ..self };
        let first = ramps.ramp_time(cruise.abs_diff(self.velocity)).min(duration);
        let last = (duration - ramps.ramp_time(cruise.unsigned_abs())).max(first);
        ramps.ends = [first, last, duration];
        ramps
    }

    #[inline]
    fn stretched_cruise(&self, duration: i128) -> i64 {
        let (half, v0) = (i128::from(self.half), i128::from(self.velocity));
        if v0 > 0 {
            // (4)
            let cruised = (self.distance - div(mul(v0, v0), 4 * half)).max(0);
            let time = duration - self.ramp_time(self.velocity.unsigned_abs());
            if time > 0 {
                let cruise = div(cruised << TICK_BITS, time);
                if cruise <= v0 {
                    return cruise as i64;
                }
            }
        }
        // (5)
        let mut cruise = v0.max(0);
        // Quadratic convergence, except that near tc = 0 each step halves the distance to the root.
        for _ in 0..i64::BITS {
            let ramped = mul(cruise, cruise) + mul(cruise - v0, cruise - v0);
            let reached = (mul(cruise, duration) >> TICK_BITS) - div(ramped, 4 * half);
            let slope = duration - div((2 * cruise - v0) << TICK_BITS, 2 * half);
            let missing = self.distance - reached;
            if missing <= 0 || slope <= 0 {
                break;
            }
            let step = div(missing << TICK_BITS, slope);
            cruise = (cruise + step).min(i128::from(self.cruise));
            if step == 0 {
                break;
            }
        }
        cruise as i64
    }

    /// The motion from rest of another wheel that keeps the proportion to this one throughout.
    ///
    /// This wheel starts from rest too and goes at least as far.
    #[inline]
    pub fn in_proportion(&self, distance: i128) -> Self {
        const RATIO_BITS: u32 = 48;
        let magnitude = distance.abs();
        debug_assert!(self.velocity == 0 && magnitude <= self.distance);
        let ratio = div(magnitude << RATIO_BITS, self.distance);
        let scaled = |value: i64| {
            ((mul(value.into(), ratio) + (1 << (RATIO_BITS - 1))) >> RATIO_BITS) as i64
        };
        Self {
            mirrored: distance < 0,
            distance: magnitude,
            half: scaled(self.half),
            cruise: scaled(self.cruise),
            ..*self
        }
    }

    /// Time from start to end [2^-32 ticks].
    pub const fn duration(&self) -> i128 {
        self.ends[2]
    }

    /// Time of the longest ramp from or to zero [2^-32 ticks].
    #[inline]
    pub fn longest_ramp(&self) -> i128 {
        self.ramp_time(self.velocity.unsigned_abs()).max(self.ends[2] - self.ends[1])
    }

    #[inline]
    fn ramp_time(&self, change: u64) -> i128 {
        div(i128::from(change) << TICK_BITS, (2 * i128::from(self.half)).max(1))
    }

    /// The motion sampled at ticks, from position `from` [2^-64 m].
    #[inline]
    pub fn course(&self, from: i128) -> Course {
        let [ramp_end, cruise_end, end] = self.ends;
        let rising = if self.cruise >= self.velocity { self.half } else { -self.half };
        let rising = if ramp_end == 0 { 0 } else { rising };

        let cruise_first = ceil(ramp_end);
        let ramped = fall(rising, ramp_end) + (mul(self.velocity.into(), ramp_end) >> TICK_BITS);
        let into_cruise = (i128::from(cruise_first) << TICK_BITS) - ramp_end;
        let at_cruise = ramped + (mul(self.cruise.into(), into_cruise) >> TICK_BITS);

        let last_first = ceil(cruise_end);
        let left = (end - (i128::from(last_first) << TICK_BITS)).max(0);
        let at_last = self.distance - fall(self.half, left);
        let last_velocity = (mul(2 * i128::from(self.half), left) >> TICK_BITS) as i64;

        let phase = |first_tick, travelled: i128, velocity: i64, half: i64| {
            let sign = if self.mirrored { -1 } else { 1 };
            let position = from + mirror(travelled, self.mirrored);
            Phase::new(first_tick, position, sign * velocity, sign * half)
        };
        Course::new([
            phase(0, 0, self.velocity, rising),
            phase(cruise_first, at_cruise, self.cruise, 0),
            phase(last_first, at_last, last_velocity, -self.half),
            phase(ceil(end), self.distance, 0, 0),
        ])
    }
}

/// First tick at or after a time.
#[inline]
pub(super) fn ceil(time: i128) -> u32 {
    ((time + (1 << TICK_BITS) - 1) >> TICK_BITS) as u32
}

/// Distance gained from rest in a time: half a t^2.
#[inline]
fn fall(half: i64, time: i128) -> i128 {
    let velocity = mul(2 * i128::from(half), time) >> TICK_BITS;
    mul(velocity, time) >> (TICK_BITS + 1)
}

#[inline]
fn square(velocity: i64) -> i128 {
    mul(velocity.into(), velocity.into())
}

#[inline]
fn mirror(distance: i128, mirrored: bool) -> i128 {
    if mirrored { -distance } else { distance }
}
