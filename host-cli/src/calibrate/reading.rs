//! What a person reads off a ruler, as typed in.

use robot_model::calibration::Deviation;

use crate::quantity::{Length, join_units};

/// One length is the lateral offset, two are the paper's dx and dy.
pub(super) fn parse_reading(text: &str, sigma_m: f64) -> std::result::Result<Deviation, String> {
    let lengths: Vec<Length> = join_units(text)
        .iter()
        .map(|part| part.parse().map_err(|error| format!("{error}")))
        .collect::<std::result::Result<_, _>>()?;
    match lengths.as_slice() {
        [offset] => Ok(Deviation::LateralOffset { y_m: offset.m, sigma_m }),
        [dx, dy] if dx.m > 0.0 => Ok(Deviation::Tangent { dx_m: dx.m, dy_m: dy.m, sigma_m }),
        [_, _] => Err("dx must be above zero".into()),
        _ => Err("give one length, or two: -36mm, or 2.525cm 1mm".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_length_is_an_offset_and_two_are_the_papers_triangle() {
        let sigma_m = 0.0005;
        match parse_reading("-36 mm", sigma_m) {
            Ok(Deviation::LateralOffset { y_m, .. }) => assert!((y_m + 0.036).abs() < 1e-12),
            other => panic!("{other:?}"),
        }
        match parse_reading("2.525 cm, 1mm", sigma_m) {
            Ok(Deviation::Tangent { dx_m, dy_m, .. }) => {
                assert!((dx_m - 0.02525).abs() < 1e-12 && (dy_m - 0.001).abs() < 1e-12);
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn an_answer_without_a_unit_is_asked_again() {
        assert!(parse_reading("36", 0.0005).is_err());
        assert!(parse_reading("", 0.0005).is_err());
        assert!(parse_reading("1mm 2mm 3mm", 0.0005).is_err());
    }
}
