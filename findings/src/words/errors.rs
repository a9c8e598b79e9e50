//! Why a calibration gives no W_T, in words.

use robot_model::calibration::out_and_back::OutAndBackError;
use robot_model::calibration::{TrackFitError, WheelWeightError};
use robot_model::kinematics::{GeometryError, Limit};

/// Why a reading gives no W_T, and what to check.
pub fn wheel_weight_error(error: &WheelWeightError) -> String {
    match error {
        WheelWeightError::Geometry(error) => geometry_error(error),
        WheelWeightError::BadNumber { name, value } => bad_number(name, *value),
        WheelWeightError::NoTravel => {
            "the wheels did not turn: drive a straight run first".to_owned()
        }
        WheelWeightError::OffsetTooLarge { offset_m, largest_m } => format!(
            "a lateral offset of {} m is out of reach of this run (at most {largest_m:.3} m): \
             check the unit and the counts",
            readable(*offset_m)
        ),
        WheelWeightError::Impossible { value } => format!(
            "this deviation gives W_T = {}: check its unit and the counts",
            readable((value * 1e3).round() / 1e3)
        ),
    }
}

/// Why a track cannot be fitted, and what to check.
pub fn track_fit_error(error: &TrackFitError) -> String {
    match error {
        TrackFitError::Geometry(error) => geometry_error(error),
        TrackFitError::TooFewSamples { found, needed } => format!(
            "{found} samples of the track lie within the run, and a fit needs {needed}: check that both use \
             the same clock"
        ),
        TrackFitError::BadNumber { name, value } => bad_number(name, *value),
        TrackFitError::TimeNotIncreasing { name, t_s } => {
            format!("the time of the {name} does not increase at {t_s} s")
        }
        TrackFitError::NoTravel => {
            "the wheels did not turn while the track was measured".to_owned()
        }
        TrackFitError::NotConverged => {
            "no wheel weight explains this track: check its clock, its unit and its axes \
             (x forward, y left)"
                .to_owned()
        }
    }
}

/// Why radius and pull cannot be separated, and what to do.
pub fn out_and_back_error(error: &OutAndBackError) -> String {
    match error {
        OutAndBackError::SameDirection => {
            "both runs went the same way: drive one of them backwards, without turning the robot"
                .to_owned()
        }
        OutAndBackError::BadNumber => "an angle is not finite, or its sigma is negative".to_owned(),
        OutAndBackError::Mixed => "both runs must be read in the same way".to_owned(),
        OutAndBackError::Reading(error) => wheel_weight_error(error),
    }
}

/// Which number of a geometry no robot has.
fn geometry_error(error: &GeometryError) -> String {
    let limit = match error.limit {
        Limit::AboveZero => "must be above zero",
        Limit::NotNegative => "must not be negative",
    };
    format!("the {} is {}: it {limit}", error.name, readable(error.value))
}

fn bad_number(name: &str, value: f64) -> String {
    format!("{name} cannot be {}", readable(value))
}

/// A number without rows of zeros: `1e300`.
fn readable(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-9..1e15).contains(&size) || !size.is_finite() {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_named_and_reads_well_whatever_its_size() {
        let refused = |value| WheelWeightError::BadNumber { name: "dx", value };
        assert_eq!(wheel_weight_error(&refused(0.0)), "dx cannot be 0");
        assert_eq!(wheel_weight_error(&refused(1e300)), "dx cannot be 1e300");
        let geometry = GeometryError { name: "track width", value: -0.4, limit: Limit::AboveZero };
        assert_eq!(
            track_fit_error(&TrackFitError::Geometry(geometry)),
            "the track width is -0.4: it must be above zero"
        );
        let reading = OutAndBackError::Reading(WheelWeightError::Impossible { value: -1.0 });
        assert_eq!(
            out_and_back_error(&reading),
            "this deviation gives W_T = -1: check its unit and the counts"
        );
    }
}
