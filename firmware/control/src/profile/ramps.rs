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

use super::course::{Course, Phase};
use crate::real::{above, larger, nearest, real, smaller, sqrt, whole};

/// Fractional bits of positions, velocities and accelerations in a [`Phase`].
const STEP_BITS: u32 = 64;

/// What one wheel has to do, and what it may use for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Task {
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
    /// -1 where the wheel goes backward, else 1: the frame of the task, which has its own cruise speed.
    sign: f64,
    task: Task,
    /// End of the first ramp, of the cruise, and of the last ramp \[ticks\].
    ends: [f64; 3],
}

impl Ramps {
    /// The quickest motion within the limits.
    #[inline]
    pub fn quickest(task: &Task) -> Self {
        let Task { half, cruise: limit, .. } = *task;
        let a = 2.0 * half;
        let braking = task.velocity * task.velocity.abs() / (2.0 * a);
        let backward = above(braking, task.distance);
        let sign = if backward { -1.0 } else { 1.0 };
        let (distance, velocity) = (sign * task.distance, sign * task.velocity);
        let v0_squared = velocity * velocity;
        let cruise = if above(velocity, limit) {
            limit
        } else {
            // (3), unless that is too fast
            smaller(larger(sqrt(a * distance + 0.5 * v0_squared), velocity), limit)
        };
        // (2)
        let cruise_squared = cruise * cruise;
        let gain = (cruise_squared - v0_squared) / (2.0 * a);
        let first = if above(velocity, cruise) { -gain } else { gain };
        let cruised = larger(distance - first - cruise_squared / (2.0 * a), 0.0);
        // (1)
        let ramp_end = (cruise - velocity).abs() / a;
        let cruise_end = if above(cruise, 0.0) { ramp_end + cruised / cruise } else { ramp_end };
        let ends = [ramp_end, cruise_end, cruise_end + cruise / a];
        Self { sign, task: Task { distance, velocity, half, cruise }, ends }
    }

    /// Takes a longer time for the same distance, by a lower cruise speed.
    #[inline]
    pub fn stretch(&mut self, duration: f64) {
        if above(duration, self.duration()) {
            let cruise = self.stretched_cruise(duration);
            let a = 2.0 * self.task.half;
            let ramp_end = smaller((cruise - self.task.velocity).abs() / a, duration);
            self.task.cruise = cruise;
            self.ends = [ramp_end, larger(duration - cruise / a, ramp_end), duration];
        }
    }

    #[inline]
    fn stretched_cruise(&self, duration: f64) -> f64 {
        let Task { distance, velocity: v0, half, cruise: highest } = self.task;
        let a = 2.0 * half;
        let (v0_squared, time) = (v0 * v0, duration - v0 / a);
        if above(v0, 0.0) && above(time, 0.0) {
            // (4)
            let cruise = larger(distance - v0_squared / (2.0 * a), 0.0) / time;
            if above(v0, cruise) {
                return cruise;
            }
        }
        // (5)
        let (b, c) = (v0 + a * duration, v0_squared + 2.0 * a * distance);
        smaller(larger(c / (b + sqrt(b * b - 2.0 * c)), larger(v0, 0.0)), highest)
    }

    /// The motion from rest of another wheel that keeps the proportion to this one throughout.
    ///
    /// This wheel starts from rest too and goes at least as far.
    #[inline]
    pub fn in_proportion(&self, distance: f64) -> Self {
        let magnitude = distance.abs();
        debug_assert!(self.task.velocity == 0.0 && magnitude <= self.task.distance);
        let ratio = magnitude / self.task.distance;
        Self {
            sign: if distance.is_sign_negative() { -1.0 } else { 1.0 },
            task: Task {
                distance: magnitude,
                velocity: 0.0,
                half: self.task.half * ratio,
                cruise: self.task.cruise * ratio,
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
        let (speed, last) = (self.task.velocity.abs(), self.ends[2] - self.ends[1]);
        // A wheel that stands still all the time has no acceleration to divide by.
        if above(speed, 0.0) { larger(speed / (2.0 * self.task.half), last) } else { last }
    }

    /// The motion sampled at ticks, from position `from` [2^-64 m].
    #[inline]
    pub fn course(&self, from: i128) -> Course {
        let Self { sign, task: Task { distance, velocity, half, cruise }, ends } = *self;
        let [ramp_end, _, end] = ends;
        let [cruise_first, last_first, end_first] = ends.map(ceil);
        let rising = if above(velocity, cruise) { -half } else { half };
        let rising = if above(ramp_end, 0.0) { rising } else { 0.0 };
        let into_cruise = ticks(cruise_first) - ramp_end;
        let at_cruise = (rising * ramp_end + velocity) * ramp_end + cruise * into_cruise;
        let left = larger(end - ticks(last_first), 0.0);
        let last_velocity = 2.0 * half * left;
        let at_last = distance - half * left * left;
        let phases = [
            (0, 0.0, velocity, rising),
            (cruise_first, at_cruise, cruise, 0.0),
            (last_first, at_last, last_velocity, -half),
            (end_first, distance, 0.0, 0.0),
        ];
        Course::new(phases.map(|(first_tick, travelled, velocity, half)| {
            let [velocity, half] = [velocity, half].map(|value| nearest(sign * value, STEP_BITS));
            Phase::new(first_tick, from + position_steps(sign * travelled), velocity, half)
        }))
    }
}

/// A distance in steps of 2^-64 m, exactly but for what is less than a step.
#[inline(never)]
pub(super) fn position_steps(metres: f64) -> i128 {
    const HALF: f64 = 4_294_967_296.0;
    let high = whole(metres, 32);
    let low = whole((metres * HALF - real(high)) / HALF, STEP_BITS);
    (i128::from(high) << 32) + i128::from(low)
}

/// First tick at or after a time \[ticks\].
#[inline(never)]
pub(super) fn ceil(time: f64) -> u32 {
    let whole = whole(time, 0) as u32;
    if above(time, ticks(whole)) { whole + 1 } else { whole }
}

/// A number of ticks, below 2^32.
#[inline]
fn ticks(number: u32) -> f64 {
    real(number.into())
}
