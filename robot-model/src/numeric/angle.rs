//! Angles: wrapping, and sin(x) / x.

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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
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
