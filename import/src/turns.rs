//! The angles of wheels, as if nothing had been wrapped: joints that stay within a turn, counters of 8 to 32 bits.

use std::f64::consts::{PI, TAU};

use crate::log::{WheelLog, WheelUnit};

/// The numbers of a wrapped joint end a little beyond its range.
const SLACK: f64 = 1e-3;
/// Counters have so many bits.
const COUNTER_BITS: std::ops::RangeInclusive<i32> = 8..=32;
/// The step at which a counter goes round is at most so many times the largest of the others.
const STEP_TIMES: f64 = 2.0;

/// Takes wraps out of both wheels; what was done, in words.
pub fn unwrap(log: &mut WheelLog) -> Vec<String> {
    let mut said = Vec::new();
    for (side, name) in ["left", "right"].into_iter().enumerate() {
        let numbers: Vec<f64> = log.turned.iter().map(|turned| turned[side]).collect();
        let Some(modulus) = modulus(&numbers, log.unit) else { continue };
        let mut turns = 0.0;
        let mut before = numbers[0];
        for (turned, number) in log.turned.iter_mut().zip(&numbers) {
            turns -= ((number - before) / modulus).round();
            before = *number;
            turned[side] = number + turns * modulus;
        }
        said.push(match log.unit {
            WheelUnit::Radians => format!(
                "the angle of the {name} wheel stays within one turn: its turns were counted"
            ),
            _ => format!(
                "the {name} counter has {} bits and wrapped around: corrected",
                modulus.log2()
            ),
        });
    }
    said
}

/// Samples go to and fro if so many of them do, by more than this, and come back to a tenth of it \[rad\].
const TO_AND_FRO: f64 = 0.2;
const FAR_RAD: f64 = 0.5;

/// Whether the samples of two robots are mixed: each goes far away, and the next comes back.
pub fn are_of_two_robots(log: &WheelLog) -> bool {
    let goes_and_comes = |side: usize, three: &[[f64; 2]]| {
        let [gone, left] = [1, 2].map(|later| (three[later][side] - three[0][side]).abs());
        gone > FAR_RAD && left < 0.1 * gone
    };
    let threes = log.turned.windows(3);
    let all = threes.len();
    let mixed = threes.filter(|three| (0..2).any(|side| goes_and_comes(side, three))).count();
    mixed as f64 > TO_AND_FRO * all as f64
}

/// After how much a wheel's numbers begin again, if they do: they stay within that, jump by most of it, and go on after each jump
/// as they went before. A counter that restarts does not.
fn modulus(numbers: &[f64], unit: WheelUnit) -> Option<f64> {
    let (low, high) =
        numbers.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), number| {
            (low.min(*number), high.max(*number))
        });
    let candidates: Vec<(f64, f64)> = match unit {
        WheelUnit::Radians => vec![(-PI, TAU), (0.0, TAU)],
        WheelUnit::Counts => {
            let moduli = COUNTER_BITS.map(|bits| 2_f64.powi(bits));
            moduli.flat_map(|modulus| [(-modulus / 2.0, modulus), (0.0, modulus)]).collect()
        }
        WheelUnit::Metres => Vec::new(),
    };
    candidates.into_iter().find_map(|(from, modulus)| {
        let slack = SLACK * modulus;
        let is_within = low >= from - slack && high <= from + modulus + slack;
        (is_within && goes_round(numbers, modulus)).then_some(modulus)
    })
}

/// Whether numbers jump by most of a modulus, and are steps like the others without it.
fn goes_round(numbers: &[f64], modulus: f64) -> bool {
    let (mut jumps, mut largest, mut largest_of_jumps) = (0, 0.0_f64, 0.0_f64);
    for pair in numbers.windows(2) {
        let step = (pair[1] - pair[0]).abs();
        if step > 0.75 * modulus {
            jumps += 1;
            largest_of_jumps = largest_of_jumps.max((modulus - step).abs());
        } else {
            largest = largest.max(step);
        }
    }
    // The step at the jump may be the fastest of the log, or the others may be none.
    jumps > 0 && largest_of_jumps <= STEP_TIMES * largest + SLACK * modulus
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(unit: WheelUnit, number: impl Fn(f64) -> f64) -> WheelLog {
        let turned = (0..2000).map(|k| [number(f64::from(k)), f64::from(k) * 1e-4]).collect();
        WheelLog { turned, unit, ..WheelLog::default() }
    }

    #[test]
    fn turns_and_counters_that_went_round_are_counted_forwards_and_backwards() {
        type Case = (WheelUnit, fn(f64) -> f64, fn(f64) -> f64);
        let cases: [Case; 6] = [
            (WheelUnit::Counts, |k| 17.0 * k, |counts| counts.rem_euclid(4096.0)),
            (WheelUnit::Counts, |k| -9.0 * k, |counts| (counts + 128.0).rem_euclid(256.0) - 128.0),
            (WheelUnit::Radians, |k| 0.05 * k, |rad| (rad + PI).rem_euclid(TAU) - PI),
            (WheelUnit::Radians, |k| -0.05 * k, |rad| rad.rem_euclid(TAU)),
            (
                WheelUnit::Counts,
                |k| 100.0 * k,
                |counts| (counts + 32_768.0).rem_euclid(65_536.0) - 32_768.0,
            ),
            (WheelUnit::Counts, |k| 4.2e9 + 1e5 * k, |counts| counts.rem_euclid(4_294_967_296.0)),
        ];
        for (unit, whole, wrapped) in cases {
            let mut log = log(unit, |k| wrapped(whole(k)));
            let said = unwrap(&mut log);
            assert_eq!(said.len(), 1, "{said:?}");
            for (k, turned) in log.turned.iter().enumerate() {
                let expected = whole(k as f64) - whole(0.0);
                assert!((turned[0] - log.turned[0][0] - expected).abs() < 1e-6, "{k}: {turned:?}");
            }
        }
    }

    #[test]
    fn a_counter_that_restarts_has_not_gone_round() {
        for (unit, step, until) in [
            (WheelUnit::Counts, 17.0, 220.0),
            (WheelUnit::Counts, 60.0, 1050.0),
            (WheelUnit::Radians, 0.01, 550.0),
        ] {
            let mut log = log(unit, |k| step * (k % until));
            let before = log.clone();
            assert_eq!(unwrap(&mut log), Vec::<String>::new());
            assert_eq!(log, before);
        }
    }

    #[test]
    fn samples_of_two_robots_go_to_and_fro() {
        assert!(!are_of_two_robots(&log(WheelUnit::Radians, |k| 0.1 * k)));
        assert!(!are_of_two_robots(&log(WheelUnit::Radians, |k| (0.05 * k).rem_euclid(TAU))));
        assert!(are_of_two_robots(&log(WheelUnit::Radians, |k| 0.01 * k + 3.0 * (k % 2.0))));
    }

    #[test]
    fn a_wheel_that_wraps_nowhere_is_left_alone() {
        let mut log = log(WheelUnit::Radians, |k| 0.001 * k);
        let before = log.clone();
        assert!(unwrap(&mut log).is_empty());
        assert_eq!(log, before);
    }
}
