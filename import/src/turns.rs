//! The angles of wheels, as if nothing had been wrapped: joints that stay within a turn, counters of 16 and 32 bits.

use std::f64::consts::{PI, TAU};

use crate::log::{WheelLog, WheelUnit};

/// The numbers of a wrapped joint end a little beyond its range.
const SLACK: f64 = 1e-3;

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
                "the {name} counter has {} bits and went round: that was taken out",
                modulus.log2()
            ),
        });
    }
    said
}

/// After how much a wheel's numbers begin again, if they do: they stay within that, and jump by most of it.
fn modulus(numbers: &[f64], unit: WheelUnit) -> Option<f64> {
    let (low, high) =
        numbers.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), number| {
            (low.min(*number), high.max(*number))
        });
    let jump = numbers.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    let candidates: &[(f64, f64)] = match unit {
        WheelUnit::Radians => &[(-PI, TAU), (0.0, TAU)],
        WheelUnit::Counts => &[
            (-32_768.0, 65_536.0),
            (0.0, 65_536.0),
            (-2_147_483_648.0, 4_294_967_296.0),
            (0.0, 4_294_967_296.0),
        ],
        WheelUnit::Metres => &[],
    };
    candidates.iter().copied().find_map(|(from, modulus)| {
        let slack = SLACK * modulus;
        let is_within = low >= from - slack && high <= from + modulus + slack;
        (is_within && jump > 0.75 * modulus).then_some(modulus)
    })
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
        let cases: [Case; 4] = [
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
    fn a_wheel_that_wraps_nowhere_is_left_alone() {
        let mut log = log(WheelUnit::Radians, |k| 0.001 * k);
        let before = log.clone();
        assert!(unwrap(&mut log).is_empty());
        assert_eq!(log, before);
    }
}
