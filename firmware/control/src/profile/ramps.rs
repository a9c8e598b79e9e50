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
//! (5) is solved for vc as c / (b + sqrt(b^2 - 2 c)) with b = v0 + a t3 and c = v0^2 + 2 a d: the smaller
//! root, without a difference of what is nearly equal. Units: m, ticks, in double precision. Its
//! rounding moves where two phases meet by some 2^-52 of the distance, 10 pm in 20 km, and by nothing where the
//! motion ends.

use super::trajectory::{Phase, Trajectory};
use crate::soft_float::{is_above, max, min, nearest, sqrt, to_f64, truncate};

/// Fractional bits of positions, velocities and accelerations in a [`Phase`].
const STEP_BITS: u32 = 64;

/// One wheel's distance, initial velocity and limits.
#[derive(Clone, Copy, Debug)]
pub(super) struct WheelMove {
    /// Signed distance \[m\].
    pub distance: f64,
    /// Initial velocity \[m/tick\].
    pub velocity: f64,
    /// Half the acceleration, above zero \[m/tick^2\].
    pub half: f64,
    /// Cruise speed, above zero \[m/tick\].
    pub cruise: f64,
}

/// A wheel's motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ramps {
    /// -1 where the wheel goes backward, else 1. The frame in which `wheel_move` is given.
    sign: f64,
    wheel_move: WheelMove,
    /// End of the first ramp, of the cruise, and of the last ramp \[ticks\].
    ends: [f64; 3],
}

impl Ramps {
    /// The quickest motion within the limits.
    #[inline]
    pub fn quickest(wheel_move: &WheelMove) -> Self {
        let WheelMove { half, cruise: limit, .. } = *wheel_move;
        let a = 2.0 * half;
        let braking = wheel_move.velocity * wheel_move.velocity.abs() / (2.0 * a);
        let backward = is_above(braking, wheel_move.distance);
        let sign = if backward { -1.0 } else { 1.0 };
        let (distance, velocity) = (sign * wheel_move.distance, sign * wheel_move.velocity);
        let v0_squared = velocity * velocity;
        let cruise = if is_above(velocity, limit) {
            limit
        } else {
            // (3), up to the limit
            min(max(sqrt(a * distance + 0.5 * v0_squared), velocity), limit)
        };
        // (2)
        let cruise_squared = cruise * cruise;
        let gain = (cruise_squared - v0_squared) / (2.0 * a);
        let first = if is_above(velocity, cruise) { -gain } else { gain };
        let cruised = max(distance - first - cruise_squared / (2.0 * a), 0.0);
        // (1)
        let ramp_end = (cruise - velocity).abs() / a;
        let cruise_end = if is_above(cruise, 0.0) { ramp_end + cruised / cruise } else { ramp_end };
        let ends = [ramp_end, cruise_end, cruise_end + cruise / a];
        Self { sign, wheel_move: WheelMove { distance, velocity, half, cruise }, ends }
    }

    /// Stretches the motion to a longer duration, by a lower cruise speed.
    #[inline]
    pub fn stretch(&mut self, duration: f64) {
        if is_above(duration, self.duration()) {
            let cruise = self.stretched_cruise(duration);
            let a = 2.0 * self.wheel_move.half;
            let ramp_end = min((cruise - self.wheel_move.velocity).abs() / a, duration);
            self.wheel_move.cruise = cruise;
            self.ends = [ramp_end, max(duration - cruise / a, ramp_end), duration];
        }
    }

    #[inline]
    fn stretched_cruise(&self, duration: f64) -> f64 {
        let WheelMove { distance, velocity: v0, half, cruise: highest } = self.wheel_move;
        let a = 2.0 * half;
        let (v0_squared, time) = (v0 * v0, duration - v0 / a);
        if is_above(v0, 0.0) && is_above(time, 0.0) {
            // (4)
            let cruise = max(distance - v0_squared / (2.0 * a), 0.0) / time;
            if is_above(v0, cruise) {
                return cruise;
            }
        }
        // (5)
        let (b, c) = (v0 + a * duration, v0_squared + 2.0 * a * distance);
        min(max(c / (b + sqrt(b * b - 2.0 * c)), max(v0, 0.0)), highest)
    }

    /// The motion from rest of another wheel that keeps the proportion to this one throughout.
    ///
    /// This wheel starts from rest too and goes at least as far.
    #[inline]
    pub fn in_proportion(&self, distance: f64) -> Self {
        let magnitude = distance.abs();
        debug_assert!(self.wheel_move.velocity == 0.0 && magnitude <= self.wheel_move.distance);
        let ratio = magnitude / self.wheel_move.distance;
        Self {
            sign: if distance.is_sign_negative() { -1.0 } else { 1.0 },
            wheel_move: WheelMove {
                distance: magnitude,
                velocity: 0.0,
                half: self.wheel_move.half * ratio,
                cruise: self.wheel_move.cruise * ratio,
            },
            ends: self.ends,
        }
    }

    /// Time from start to end \[ticks\].
    pub const fn duration(&self) -> f64 {
        self.ends[2]
    }

    /// Time of the longest ramp from or to zero \[ticks\].
    #[inline]
    pub fn longest_ramp(&self) -> f64 {
        let (speed, last) = (self.wheel_move.velocity.abs(), self.ends[2] - self.ends[1]);
        // A wheel that stands still all the time has no acceleration to divide by.
        if is_above(speed, 0.0) { max(speed / (2.0 * self.wheel_move.half), last) } else { last }
    }

    /// The motion sampled at ticks, from position `from` [2^-64 m].
    #[inline]
    pub fn trajectory(&self, from: i128) -> Trajectory {
        let Self { sign, wheel_move: WheelMove { distance, velocity, half, cruise }, ends } = *self;
        let [ramp_end, _, end] = ends;
        let [cruise_first, last_first, end_first] = ends.map(ceil);
        let rising = if is_above(velocity, cruise) { -half } else { half };
        let rising = if is_above(ramp_end, 0.0) { rising } else { 0.0 };
        let into_cruise = ticks(cruise_first) - ramp_end;
        let at_cruise = (rising * ramp_end + velocity) * ramp_end + cruise * into_cruise;
        let left = max(end - ticks(last_first), 0.0);
        let last_velocity = 2.0 * half * left;
        let at_last = distance - half * left * left;
        let phases = [
            (0, 0.0, velocity, rising),
            (cruise_first, at_cruise, cruise, 0.0),
            (last_first, at_last, last_velocity, -half),
            (end_first, distance, 0.0, 0.0),
        ];
        Trajectory::new(phases.map(|(first_tick, travelled, velocity, half)| {
            let [velocity, half] = [velocity, half].map(|value| nearest(sign * value, STEP_BITS));
            Phase::new(first_tick, from + position_steps(sign * travelled), velocity, half)
        }))
    }
}

/// A distance in whole steps of 2^-64 m.
#[inline(never)]
pub(super) fn position_steps(metres: f64) -> i128 {
    const HALF: f64 = 4_294_967_296.0;
    let high = truncate(metres, 32);
    let low = truncate((metres * HALF - to_f64(high)) / HALF, STEP_BITS);
    (i128::from(high) << 32) + i128::from(low)
}

/// First tick at or after a time \[ticks\].
#[inline(never)]
pub(super) fn ceil(time: f64) -> u32 {
    let whole = truncate(time, 0) as u32;
    if is_above(time, ticks(whole)) { whole + 1 } else { whole }
}

/// A number of ticks, below 2^32.
#[inline]
fn ticks(number: u32) -> f64 {
    to_f64(number.into())
}
