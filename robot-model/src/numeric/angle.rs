//! Angles: wrapping, sin(x) / x, and directions that turn step by step.

use core::f64::consts::{PI, TAU};

use crate::numeric::lanes::Number;

/// An angle brought to -pi..pi \[rad\].
pub(crate) fn wrap(angle_rad: f64) -> f64 {
    if (-PI..PI).contains(&angle_rad) {
        return angle_rad;
    }
    let turned = (angle_rad + PI).rem_euclid(TAU) - PI;
    // Right at the seam, rounding may give pi itself.
    if turned >= PI { -PI } else { turned }
}

/// sin(x) / x, exact to rounding at and near zero.
pub(crate) fn sinc<T: Number>(x: T) -> T {
    if x.largest() >= SMALL_RAD {
        return x.each(|x| if x == 0.0 { 1.0 } else { x.sin() / x });
    }
    // The first term left out, x^10 / 11!, is under 1e-17; a sine would cost more.
    let square = x * x;
    let one = T::of(1.0);
    [72.0, 42.0, 20.0, 6.0].into_iter().fold(one, |sum, n| one - square * T::of(1.0 / n) * sum)
}

/// d sinc(x) / dx, where sinc(x) is given.
pub(crate) fn sinc_slope(x: f64, sinc: f64) -> f64 {
    if x.abs() >= 0.1 {
        return (x.cos() - sinc) / x;
    }
    // The difference would cancel; the first term left out, x^9 / 3991680, is under 1e-15.
    let square = x * x;
    -x / 3.0 * (1.0 - square / 10.0 * (1.0 - square / 28.0 * (1.0 - square / 54.0)))
}

/// A direction, as the sine and cosine of its angle: to turn it by a small angle takes no sine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Direction<T = f64> {
    pub sin: T,
    pub cos: T,
}

/// Below this, [`Direction::of_small`] is exact to rounding \[rad\].
const SMALL_RAD: f64 = 0.1;

impl<T: Number> Direction<T> {
    pub fn of(angle_rad: T) -> Self {
        let (sin, cos) = angle_rad.sin_cos();
        Self { sin, cos }
    }

    /// That of x, where sinc(x) is given.
    pub fn of_small(x: T, sinc: T) -> Self {
        if x.largest() >= SMALL_RAD {
            return Self::of(x);
        }
        // The first term left out, x^12 / 12!, is under 1e-20.
        let square = x * x;
        let [one, half] = [1.0, 0.5].map(T::of);
        let rest = [90.0, 56.0, 30.0, 12.0];
        let rest = rest.into_iter().fold(one, |sum, n| one - square * T::of(1.0 / n) * sum);
        Self { sin: x * sinc, cos: one - square * half * rest }
    }

    /// Turned by another one's angle.
    pub fn turned(self, by: Self) -> Self {
        Self {
            sin: self.sin * by.cos + self.cos * by.sin,
            cos: self.cos * by.cos - self.sin * by.sin,
        }
    }
}

impl Direction {
    /// Turned back by another one's angle.
    pub fn turned_back(self, by: Self) -> Self {
        self.turned(Self { sin: -by.sin, ..by })
    }

    /// Twice the sine of half the angle, with its sign: the chord that the angle spans on the unit circle.
    pub fn chord(self) -> f64 {
        if self.cos > 0.0 {
            return self.sin * (2.0 / (1.0 + self.cos)).sqrt();
        }
        (2.0 * (1.0 - self.cos)).sqrt().copysign(self.sin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_direction_turned_is_that_of_the_sum_of_the_angles(
            angle in -20.0_f64..20.0,
            by in -0.2_f64..0.2,
        ) {
            let turned = Direction::of(angle).turned(Direction::of_small(by, sinc(by)));
            let whole = Direction::of(angle + by);
            // The sum of the angles is itself rounded, to half of 4e-15.
            prop_assert!((turned.sin - whole.sin).abs() < 3e-15);
            prop_assert!((turned.cos - whole.cos).abs() < 3e-15);
            let back = turned.turned_back(Direction::of(angle));
            prop_assert!((back.sin - by.sin()).abs() < 1e-15);
        }

        #[test]
        fn a_chord_is_twice_the_sine_of_half_the_angle(angle in -3.1_f64..3.1) {
            let chord = Direction::of(angle).chord();
            prop_assert!((chord - 2.0 * (angle / 2.0).sin()).abs() < 1e-15, "{}", chord);
        }

        #[test]
        fn sinc_has_no_step_where_its_formula_changes(x in 0.09_f64..0.11) {
            prop_assert!((sinc(x) - x.sin() / x).abs() < 4e-16);
        }

        #[test]
        fn the_slope_of_sinc_is_its_derivative_on_both_sides_of_where_its_formula_changes(
            x in -0.2_f64..0.2,
        ) {
            let difference = (sinc(x + 1e-4) - sinc(x - 1e-4)) / 2e-4;
            prop_assert!((sinc_slope(x, sinc(x)) - difference).abs() < 1e-9);
        }
    }
}
