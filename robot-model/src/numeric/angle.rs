//! Angles: wrapping, sin(x) / x, and directions that turn step by step.

use core::f64::consts::{PI, TAU};

/// An angle brought to -pi..pi \[rad\].
pub(crate) fn wrap(angle_rad: f64) -> f64 {
    let turned = (angle_rad + PI).rem_euclid(TAU) - PI;
    // Right at the seam, rounding may give pi itself.
    if turned >= PI { -PI } else { turned }
}

/// sin(x) / x, exact to rounding at and near zero.
pub(crate) fn sinc(x: f64) -> f64 {
    if x.abs() >= 0.1 {
        return x.sin() / x;
    }
    // The first term left out, x^10 / 11!, is under 1e-17; a sine would cost more.
    let square = x * x;
    1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0)))
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
pub(crate) struct Direction {
    pub sin: f64,
    pub cos: f64,
}

impl Direction {
    pub fn of(angle_rad: f64) -> Self {
        let (sin, cos) = angle_rad.sin_cos();
        Self { sin, cos }
    }

    /// That of x, where sinc(x) is given.
    pub fn of_small(x: f64, sinc: f64) -> Self {
        if x.abs() >= 0.1 {
            return Self::of(x);
        }
        // The first term left out, x^12 / 12!, is under 1e-20.
        let square = x * x;
        let rest = 1.0 - square / 30.0 * (1.0 - square / 56.0 * (1.0 - square / 90.0));
        Self { sin: x * sinc, cos: 1.0 - square / 2.0 * (1.0 - square / 12.0 * rest) }
    }

    /// Turned by another one's angle.
    pub fn turned(self, by: Self) -> Self {
        Self {
            sin: self.sin * by.cos + self.cos * by.sin,
            cos: self.cos * by.cos - self.sin * by.sin,
        }
    }

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
