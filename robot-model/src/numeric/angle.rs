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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sinc_has_no_step_where_its_formula_changes(x in 0.09_f64..0.11) {
            prop_assert!((sinc(x) - x.sin() / x).abs() < 4e-16);
        }
    }
}
