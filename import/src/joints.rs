//! Two joints over time, whether their numbers come together or each in messages of its own.

use std::f64::consts::{PI, TAU};

use crate::log::usual_step_s;

/// The numbers of two joints, as they came.
#[derive(Clone, Debug, Default)]
pub(crate) struct JointLog {
    /// Of messages that have both \[s\].
    pub(crate) both: Vec<(f64, [f64; 2])>,
    /// Of messages that have one \[s\].
    alone: [Vec<(f64, f64)>; 2],
}

/// An angle that stays within a turn has gone round if it changes by more between two messages \[rad\].
const STEP_MAX: f64 = PI;
const WITHIN: f64 = TAU + 1e-2;
/// Between messages that are further apart than this \[s\], and so many times as far as usual, nothing is known.
const GAP_S: f64 = 0.3;
const GAP_TIMES: f64 = 3.0;

impl JointLog {
    /// Adds what a message has of them; whether it has any.
    pub(crate) fn add(&mut self, t_s: f64, numbers: [Option<f64>; 2]) -> bool {
        match numbers {
            [Some(left), Some(right)] => self.both.push((t_s, [left, right])),
            [Some(left), None] => self.alone[0].push((t_s, left)),
            [None, Some(right)] => self.alone[1].push((t_s, right)),
            [None, None] => return false,
        }
        true
    }

    /// Whether there is something of both.
    pub(crate) fn has_both(&self) -> bool {
        !self.both.is_empty() || self.alone.iter().all(|alone| !alone.is_empty())
    }

    /// Both at the times of their messages; if they only come alone, at those of the left one, between messages of the right one.
    pub(crate) fn joined(mut self) -> Vec<(f64, [f64; 2])> {
        if !self.both.is_empty() {
            return self.both;
        }
        let is_sound = |(t_s, number): &(f64, f64)| t_s.is_finite() && number.is_finite();
        for alone in &mut self.alone {
            alone.retain(is_sound);
            alone.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        let [left, right] = &self.alone;
        let (low, high) =
            right.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, number)| {
                (low.min(*number), high.max(*number))
            });
        let is_within = high - low < WITHIN;
        let usual_s = usual_step_s(right.iter().map(|(t_s, _)| *t_s)).unwrap_or(0.0);
        let gap_s = GAP_S.max(GAP_TIMES * usual_s);
        let mut next = 0;
        let mut joined = Vec::with_capacity(left.len());
        for (t_s, number) in left {
            while right.get(next).is_some_and(|(later_s, _)| later_s < t_s) {
                next += 1;
            }
            let Some(after) = right.get(next) else { break };
            let Some(before) = next.checked_sub(1).map(|index| right[index]) else {
                if after.0 == *t_s {
                    joined.push((*t_s, [*number, after.1]));
                }
                continue;
            };
            if after.0 - before.0 > gap_s {
                continue;
            }
            let share = (t_s - before.0) / (after.0 - before.0);
            let goes_round = is_within && (after.1 - before.1).abs() > STEP_MAX;
            let nearest = if share < 0.5 { before.1 } else { after.1 };
            let between = before.1 + share * (after.1 - before.1);
            joined.push((*t_s, [*number, if goes_round { nearest } else { between }]));
        }
        joined
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_that_come_alone_are_joined_between_their_messages() {
        let mut log = JointLog::default();
        for k in 0..10 {
            let t_s = f64::from(k) * 0.1;
            assert!(log.add(t_s, [Some(t_s), None]));
            assert!(log.add(t_s + 0.03, [None, Some(2.0 * t_s + 0.06)]));
            assert!(!log.add(t_s, [None, None]));
        }
        assert!(log.has_both());
        let joined = log.joined();
        // Before the first message of the right one nothing is known of it.
        assert_eq!(joined.len(), 9);
        for (t_s, [left, right]) in joined {
            assert!((left - t_s).abs() < 1e-12 && (right - 2.0 * t_s).abs() < 1e-12);
        }
    }

    #[test]
    fn an_angle_that_goes_round_is_not_averaged() {
        let mut log = JointLog::default();
        log.add(0.0, [None, Some(3.1)]);
        log.add(0.04, [Some(0.0), None]);
        log.add(0.05, [Some(0.0), None]);
        log.add(0.1, [None, Some(-3.1)]);
        let right: Vec<f64> = log.joined().iter().map(|(_, [_, right])| *right).collect();
        assert_eq!(right, [3.1, -3.1]);
    }

    #[test]
    fn a_fast_wheel_is_interpolated_and_a_gap_is_left_open() {
        let mut log = JointLog::default();
        // 16 rad/s, and a second in which the right joint is lost.
        for k in 0..200 {
            let t_s = f64::from(k) * 0.02;
            log.add(t_s, [Some(16.0 * t_s), None]);
            if k % 13 == 0 && !(1.0..2.0).contains(&t_s) {
                log.add(t_s, [None, Some(16.0 * t_s)]);
            }
        }
        let joined = log.joined();
        assert!(joined.iter().all(|(_, [left, right])| (left - right).abs() < 1e-9));
        assert!(!joined.iter().any(|(t_s, _)| (1.1..1.9).contains(t_s)));
        assert!(joined.len() > 120, "{}", joined.len());
    }
}
