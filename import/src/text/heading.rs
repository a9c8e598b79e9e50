//! In which unit headings are whose name says none: in that in which they agree with the direction of travel.
//!
//! A robot goes forwards or backwards along its heading, and a marker may be turned on it. With the heading h, the direction of travel d
//! and a unit u, the mean of `e^(2 i (u h - d))` over the path has a length near 1 if u is right, and near 0 if it is not. Of axes
//! that are mirrored the same holds with `-h`.

use std::f64::consts::{PI, TAU};

/// A direction of travel takes such a step \[m\].
const STEP_M: f64 = 0.05;
/// Steps that are longer by this factor than the shortest that counts are jumps.
const JUMP_TIMES: f64 = 10.0;
/// Fewer directions say nothing.
const STEPS_MIN: usize = 10;
/// The unit that is right agrees by more, the other one by less.
const AGREES: f64 = 0.8;
const DISAGREES: f64 = 0.5;
const DEGREE: f64 = PI / 180.0;

/// What makes radians of headings; `None` if it cannot be told. Within one turn they are taken for radians: what they are then is
/// found from the motion, later.
pub(super) fn unit(x: &[f64], y: &[f64], heading: &[f64]) -> Option<f64> {
    let largest =
        heading.iter().filter(|h| h.is_finite()).fold(0.0_f64, |most, h| most.max(h.abs()));
    if largest <= TAU {
        return Some(1.0);
    }
    let steps = steps(x, y, heading);
    if steps.len() < STEPS_MIN {
        return None;
    }
    let [radians, degrees] = [1.0, DEGREE].map(|unit| agreement(&steps, unit));
    if radians > AGREES && degrees < DISAGREES {
        Some(1.0)
    } else {
        (degrees > AGREES && radians < DISAGREES).then_some(DEGREE)
    }
}

/// Headings half way along short steps, and their directions \[rad\].
fn steps(x: &[f64], y: &[f64], heading: &[f64]) -> Vec<([f64; 2], f64)> {
    let mut steps = Vec::new();
    let mut from: Option<[f64; 3]> = None;
    for ((x, y), h) in x.iter().zip(y).zip(heading) {
        if ![x, y, h].iter().all(|number| number.is_finite()) {
            continue;
        }
        let [x_m, y_m, before] = *from.get_or_insert([*x, *y, *h]);
        let (dx, dy) = (x - x_m, y - y_m);
        let gone_m = dx.hypot(dy);
        if gone_m < STEP_M {
            continue;
        }
        if gone_m < JUMP_TIMES * STEP_M {
            steps.push(([before, *h], dy.atan2(dx)));
        }
        from = Some([*x, *y, *h]);
    }
    steps
}

/// How well headings in a unit agree with directions, counted either way round: 0 to 1.
fn agreement(steps: &[([f64; 2], f64)], unit: f64) -> f64 {
    let mean = |sign: f64| {
        let (sin, cos) = steps.iter().fold((0.0, 0.0), |(sin, cos), ([a, b], direction)| {
            // Half way, also where headings go from one end of their range to the other.
            let turned = (unit * (b - a) + PI).rem_euclid(TAU) - PI;
            let twice = 2.0 * (sign * (unit * a + turned / 2.0) - direction);
            (sin + twice.sin(), cos + twice.cos())
        });
        sin.hypot(cos) / steps.len() as f64
    };
    mean(1.0).max(mean(-1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three times round a circle of 0.5 m, in steps of 2 cm.
    fn circle(heading: impl Fn(f64) -> f64) -> [Vec<f64>; 3] {
        let rad: Vec<f64> = (0..471).map(|k| 0.04 * f64::from(k)).collect();
        let of = |number: &dyn Fn(f64) -> f64| rad.iter().map(|rad| number(*rad)).collect();
        [of(&|rad| 0.5 * rad.sin()), of(&|rad| -0.5 * rad.cos()), of(&|rad| heading(rad))]
    }

    fn unit_of(heading: impl Fn(f64) -> f64) -> Option<f64> {
        let [x, y, heading] = circle(heading);
        unit(&x, &y, &heading)
    }

    #[test]
    fn the_unit_is_that_which_agrees_with_the_path() {
        assert_eq!(unit_of(|rad| rad), Some(1.0));
        assert_eq!(unit_of(f64::to_degrees), Some(DEGREE));
        // Within a turn, clockwise, the marker turned.
        assert_eq!(unit_of(|rad| (70.0 - rad.to_degrees()).rem_euclid(360.0)), Some(DEGREE));
        assert_eq!(
            unit_of(|rad| (rad.to_degrees() + 180.0).rem_euclid(360.0) - 180.0),
            Some(DEGREE)
        );
        assert_eq!(unit_of(|rad| rad.rem_euclid(TAU)), Some(1.0));
    }

    #[test]
    fn headings_that_agree_in_no_unit_or_in_both_have_none() {
        assert_eq!(unit_of(|rad| 100.0 * rad), None);
        let [x, y] = [(0..100).map(|k| 0.02 * f64::from(k)).collect(), vec![0.0; 100]];
        assert_eq!(unit(&x, &y, &[90.0; 100]), None);
    }
}
