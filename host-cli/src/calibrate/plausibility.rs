//! Which W_T is plausible, from a calibration or from numbers that were typed in.

use robot_model::calibration::wheel_weight::SIGMAS_95;
use shared_proto::{Config, GeometryConfig};

use crate::error::{Error, Result};

/// Wheels that are sold as a pair differ by less than this share of the radius.
pub const DIFFERENCE_USUAL: f64 = 0.03;

/// Refuses a geometry that no robot accepts.
///
/// # Errors
///
/// Outside the ranges of [`Config::FIELDS`]: W_T from 0.8 to 1.25.
pub fn check(geometry: GeometryConfig) -> Result<()> {
    let config = Config { geometry, ..Config::default() };
    config.validate().map_err(|error| {
        Error::new(format_args!("the measured W_T is implausible: {error}"))
            .hint("check the readings, the track width and the counts per revolution")
    })
}

/// Why a W_T is doubtful, although a robot accepts it.
pub fn doubt(wheel_weight: f64) -> Option<&'static str> {
    ((wheel_weight - 1.0).abs() > DIFFERENCE_USUAL).then_some(
        "wheels that differ by more than 3 % are rare: are counts_per_rev, gear_reduction and the signs right?",
    )
}

/// Why a W_T with this sigma says nothing, whatever its value.
pub fn vague(sigma: f64) -> Option<&'static str> {
    (SIGMAS_95 * sigma > DIFFERENCE_USUAL).then_some(
        "the uncertainty of this W_T exceeds the 3 % by which wheels usually differ at most: measure more precisely",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_doubt_names_the_usual_difference() {
        let percent = format!("{:.0} %", 100.0 * DIFFERENCE_USUAL);
        assert!(doubt(1.0 - 1.01 * DIFFERENCE_USUAL).unwrap().contains(&percent));
        assert!(doubt(1.0 + 1.01 * DIFFERENCE_USUAL).is_some());
        assert_eq!(doubt(1.0 + 0.99 * DIFFERENCE_USUAL), None);
        assert!(vague(0.6 * DIFFERENCE_USUAL).unwrap().contains(&percent));
        assert_eq!(vague(0.5 * DIFFERENCE_USUAL), None);
    }
}
