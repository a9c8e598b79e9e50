//! Angles that go round.

use std::f64::consts::TAU;

/// The same angle within half a turn of zero \[rad\].
pub(crate) fn wrapped(rad: f64) -> f64 {
    nearest(rad, 0.0)
}

/// The same angle within half a turn of another one \[rad\].
pub(crate) fn nearest(rad: f64, to_rad: f64) -> f64 {
    rad + TAU * ((to_rad - rad) / TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_keeps_its_direction_and_comes_near() {
        for turns in -3..=3 {
            let rad = 1.25 + f64::from(turns) * TAU;
            assert!((wrapped(rad) - 1.25).abs() < 1e-12);
            assert!((nearest(rad, 7.0) - (1.25 + TAU)).abs() < 1e-12);
        }
        assert!(wrapped(TAU / 2.0 + 0.1) < 0.0);
    }
}
