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
    // Below 1e-4 the first term left out, x^4 / 120, is under 1e-18.
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sinc_has_no_step_where_its_formula_changes(x in 0.9e-4_f64..1.1e-4) {
            prop_assert!((sinc(x) - x.sin() / x).abs() < 1e-15);
        }
    }
}
