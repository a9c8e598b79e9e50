//! Which counters went round, restarted from zero, jumped, or repeat old values? And the wheels with that mended.

use crate::kinematics::wheel_pair::WheelPair;
use crate::numeric::median::median;
use crate::recording::run::{Recording, Robot, WheelSample};

use super::data_fault::{DataFault, Wheel};

/// The usual speed of a wheel is this quantile over the steps in which it turns, if there are so many.
const USUAL: f64 = 0.9;
const MOVING_MIN: usize = 5;
/// A jump is this many times as fast as usual, at least this fast \[m/s\] and this long \[m\].
const JUMP_TIMES: f64 = 8.0;
const JUMP_MPS: f64 = 0.5;
const JUMP_M: f64 = 0.03;
/// Fewer samples do not show what is usual.
const SAMPLES_MIN: usize = 20;
/// What is left of a step after a counter wrapped around is at most this many usual steps.
const WRAP_TIMES: f64 = 3.0;
/// A counter restarted from zero if it is this near to zero, in usual steps and in counts.
const ANEW: (f64, f64) = (3.0, 3.0);
/// Counts are held if most new ones come after so many samples, and are so many counts on.
const HELD_SAMPLES: usize = 3;
const HELD_COUNTS: f64 = 8.0;

/// Wheels without what was wrong with them, and what that was.
pub(super) struct Mended {
    pub(super) wheels: Vec<WheelSample>,
    pub(super) found: Vec<DataFault>,
}

/// Which counters are taken for ones that wrap around.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Wrapping {
    /// Those whose counts all lie within the range of its bits.
    WithinRange,
    /// All: one that counts further has more bits, or was extended by software that missed a wrap.
    All,
}

/// The wheels of a valid run.
pub(super) fn mended(robot: &Robot, run: &Recording, wrapping: Wrapping) -> Mended {
    let times: Vec<f64> = run.wheels.iter().map(|sample| sample.t_s).collect();
    let mut found = Vec::new();
    let side = |right: bool, found: &mut Vec<DataFault>| {
        let counts = run.wheels.iter().map(|sample| {
            let phi = sample.phi_rad;
            (if right { phi.right } else { phi.left }) / robot.rad_per_count
        });
        let mut counter = Counter {
            wheel: if right { Wheel::Right } else { Wheel::Left },
            times: &times,
            counts: counts.collect(),
            m_per_count: robot.wheel_radius_m * robot.rad_per_count,
        };
        found.extend(counter.unwrapped(wrapping));
        found.extend(counter.smoothed());
        counter.counts
    };
    let (left, right) = (side(false, &mut found), side(true, &mut found));
    let pairs = left.into_iter().zip(right).zip(&times);
    let wheels: Vec<WheelSample> = pairs
        .map(|((left, right), t_s)| WheelSample {
            t_s: *t_s,
            phi_rad: WheelPair::new(left, right).map(|counts| counts * robot.rad_per_count),
        })
        .collect();
    let wheels = match held(robot, &wheels) {
        Some((what, kept)) => {
            found.push(what);
            kept
        }
        None if found.is_empty() => run.wheels.clone(),
        None => wheels,
    };
    Mended { wheels, found: of_both(found) }
}

/// What both wheels did at once, as one.
fn of_both(found: Vec<DataFault>) -> Vec<DataFault> {
    let mut merged: Vec<DataFault> = Vec::new();
    for what in found {
        let twin = merged.iter_mut().find_map(|other| match (other, &what) {
            (DataFault::CounterReset { wheel, t_s }, DataFault::CounterReset { t_s: at, .. })
                if *t_s == *at =>
            {
                Some(wheel)
            }
            _ => None,
        });
        match twin {
            Some(wheel) => *wheel = Wheel::Both,
            None => merged.push(what),
        }
    }
    merged
}

/// The counter of one wheel.
struct Counter<'a> {
    wheel: Wheel,
    times: &'a [f64],
    counts: Vec<f64>,
    m_per_count: f64,
}

impl Counter<'_> {
    fn step(&self, k: usize) -> f64 {
        self.counts[k] - self.counts[k - 1]
    }

    /// The usual speed over the steps in which the wheel turns, without those steps \[counts/s\].
    fn usual(&self, without: &dyn Fn(usize) -> bool) -> Option<f64> {
        let steps = (1..self.counts.len()).filter(|k| !without(*k) && self.step(*k) != 0.0);
        let mut speeds: Vec<f64> =
            steps.map(|k| self.step(k).abs() / (self.times[k] - self.times[k - 1])).collect();
        speeds.sort_by(f64::total_cmp);
        let at = (USUAL * speeds.len() as f64) as usize;
        (speeds.len() >= MOVING_MIN).then(|| speeds[at.min(speeds.len() - 1)])
    }

    /// Takes out steps by the range of a counter of 16 or 32 bits, where what is left is a usual step.
    fn unwrapped(&mut self, wrapping: Wrapping) -> Option<DataFault> {
        let (bits, range) = [(16_u32, 65_536.0), (32, 4_294_967_296.0)]
            .into_iter()
            .rfind(|(_, range)| (1..self.counts.len()).any(|k| self.step(k).abs() > range / 2.0))?;
        let (least, most) = (self.counts.iter())
            .fold((f64::MAX, f64::MIN), |(least, most), count| {
                (least.min(*count), most.max(*count))
            });
        let counts_further = most - least >= range;
        if wrapping == Wrapping::WithinRange && counts_further {
            return None;
        }
        let wraps = |k: usize| self.step(k).abs() > range / 2.0;
        let usual = self.usual(&wraps)?;
        let spacing_s = median(self.times.windows(2).map(|pair| pair[1] - pair[0]).collect())?;
        // With steps so long, what is left of any step is a usual one.
        if counts_further && WRAP_TIMES * usual * spacing_s > range / 2.0 {
            return None;
        }
        let rest = |k: usize| self.step(k) - range * (self.step(k) / range).round();
        let within = |k: usize| {
            let dt_s = (self.times[k] - self.times[k - 1]).max(spacing_s);
            let step = usual * dt_s;
            rest(k).abs() <= WRAP_TIMES * step + 2.0 && self.step(k).abs() > 1.5 * step
        };
        let at: Vec<usize> = (1..self.counts.len()).filter(|k| wraps(*k)).collect();
        if !at.iter().all(|k| within(*k)) {
            return None;
        }
        let turned =
            |k: usize| if k > 0 && wraps(k) { (self.step(k) / range).round() } else { 0.0 };
        let mut shift = 0.0;
        let counts = self.counts.iter().enumerate().map(|(k, count)| {
            shift -= range * turned(k);
            count + shift
        });
        self.counts = counts.collect();
        Some(DataFault::CounterWraps {
            wheel: self.wheel,
            t_s: self.times[at[0]],
            bits,
            times: at.len(),
        })
    }

    /// Takes out steps that no wheel rolls.
    fn smoothed(&mut self) -> Vec<DataFault> {
        let mut found = Vec::new();
        if self.counts.len() <= SAMPLES_MIN {
            return found;
        }
        let usual = self.usual(&|_| false).unwrap_or(0.0);
        let limit = (JUMP_TIMES * usual).max(JUMP_MPS / self.m_per_count);
        for k in 1..self.counts.len() {
            let dt_s = self.times[k] - self.times[k - 1];
            let step = self.step(k);
            let jumps = |step: f64, dt_s: f64| {
                step.abs() / dt_s > limit && step.abs() * self.m_per_count > JUMP_M
            };
            if !jumps(step, dt_s) {
                continue;
            }
            let t_s = self.times[k];
            let (before, after) = (self.counts[k - 1], self.counts[k]);
            // Only this sample: the next one is where it would be without it.
            let alone = self.counts.get(k + 1).is_none_or(|next| {
                let over_s = self.times[k + 1] - self.times[k - 1];
                !jumps(next - before, over_s)
            });
            let near = ANEW.0 * usual * dt_s + ANEW.1;
            found.push(if !alone && after.abs() <= near && before.abs() > 2.0 * near {
                DataFault::CounterReset { wheel: self.wheel, t_s }
            } else {
                let rolled_m = step.abs() * self.m_per_count;
                DataFault::CountsJump { wheel: self.wheel, t_s, rolled_m }
            });
            if alone {
                let next = self.counts.get(k + 1).copied().unwrap_or(before);
                self.counts[k] = (before + next) / 2.0;
            } else {
                // As fast as in the step before.
                let went = if k > 1 { self.step(k - 1) } else { 0.0 };
                let shift = before + went - after;
                self.counts[k..].iter_mut().for_each(|count| *count += shift);
            }
        }
        found
    }
}

/// New counts that come only every few samples, in large steps, and the samples without those in between.
fn held(robot: &Robot, wheels: &[WheelSample]) -> Option<(DataFault, Vec<WheelSample>)> {
    let changes: Vec<usize> =
        (1..wheels.len()).filter(|k| wheels[*k].phi_rad != wheels[k - 1].phi_rad).collect();
    if changes.len() <= SAMPLES_MIN {
        return None;
    }
    let between = changes.windows(2).map(|pair| (pair[1] - pair[0]) as f64).collect();
    let step = |k: &usize| {
        let step = wheels[*k].phi_rad.since(wheels[k - 1].phi_rad);
        step.left.abs().max(step.right.abs()) / robot.rad_per_count
    };
    let counts = median(changes.iter().map(step).collect())?;
    if median(between)? < HELD_SAMPLES as f64 || counts < HELD_COUNTS {
        return None;
    }
    let every_s =
        median(changes.windows(2).map(|pair| wheels[pair[1]].t_s - wheels[pair[0]].t_s).collect())?;
    let mut kept = vec![wheels[0]];
    for k in changes {
        // After a rest, the robot begins to move one period before.
        let last_s = kept.last().map_or(f64::NEG_INFINITY, |sample| sample.t_s);
        let rested = wheels[..k].iter().rfind(|sample| sample.t_s <= wheels[k].t_s - every_s);
        if let Some(rested) = rested.filter(|sample| sample.t_s > last_s + 0.5 * every_s) {
            kept.push(*rested);
        }
        kept.push(wheels[k]);
    }
    let last = wheels[wheels.len() - 1];
    if kept.last().is_some_and(|sample| sample.t_s < last.t_s) {
        kept.push(last);
    }
    Some((DataFault::CountsHeld { every_s }, kept))
}
