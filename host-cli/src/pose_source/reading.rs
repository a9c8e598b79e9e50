//! What a person types in after reading a ruler or a tape.

use std::path::{Path, PathBuf};

use robot_model::calibration::Deviation;

use crate::quantity::{Angle, Length, join_units};

/// Reads a deviation: one length is the lateral offset, two are the paper's dx and dy.
pub(super) fn parse_deviation(text: &str, sigma_m: f64) -> std::result::Result<Deviation, String> {
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

/// A pose as typed, in metres and radians; the heading is optional.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reading {
    pub(super) x_m: f64,
    pub(super) y_m: f64,
    pub(super) heading_rad: Option<f64>,
}

/// The answer after a run.
pub(super) enum Reply {
    Pose(Reading),
    Track(PathBuf),
    Nothing,
    Repeat,
    Skip,
    Quit,
}

/// The answer to the question for the heading alone.
pub(super) enum Heading {
    /// \[rad\], if it was read.
    Read(Option<f64>),
    Repeat,
    Skip,
    Quit,
}

pub(super) fn parse_heading(text: &str) -> std::result::Result<Heading, String> {
    Ok(match text.to_lowercase().as_str() {
        "" => Heading::Read(None),
        "r" | "repeat" => Heading::Repeat,
        "s" | "skip" => Heading::Skip,
        "q" | "quit" => Heading::Quit,
        angle => {
            no_decimal_comma(angle)?;
            let angle = angle.parse::<Angle>().map_err(|error| error.to_string())?;
            Heading::Read(Some(angle.rad))
        }
    })
}

/// Refuses a decimal comma, as in `1,795m`: elsewhere a comma separates numbers.
fn no_decimal_comma(text: &str) -> std::result::Result<(), String> {
    let digits = text
        .as_bytes()
        .windows(3)
        .any(|three| three[1] == b',' && three[0].is_ascii_digit() && three[2].is_ascii_digit());
    if digits { Err(format!("`{text}`: write 1.8m, with a point, not 1,8m")) } else { Ok(()) }
}

pub(super) fn parse_reply(text: &str) -> std::result::Result<Reply, String> {
    match text.to_lowercase().as_str() {
        "" => return Ok(Reply::Nothing),
        "r" | "repeat" => return Ok(Reply::Repeat),
        "s" | "skip" => return Ok(Reply::Skip),
        "q" | "quit" => return Ok(Reply::Quit),
        _ => {}
    }
    let number = text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    if number && !Path::new(text).exists() && !text.ends_with(".csv") {
        return parse_pose(text).map(Reply::Pose);
    }
    Ok(Reply::Track(text.into()))
}

/// Reads a pose: `1.795m -12mm`, or `1.795m -12mm 3deg`.
pub(super) fn parse_pose(text: &str) -> std::result::Result<Reading, String> {
    no_decimal_comma(text)?;
    let parts = join_units(text);
    let length = |text: &str| -> std::result::Result<f64, String> {
        text.parse().map(|length: Length| length.m).map_err(|error| error.to_string())
    };
    let angle = |text: &str| -> std::result::Result<f64, String> {
        text.parse().map(|angle: Angle| angle.rad).map_err(|error| error.to_string())
    };
    let (x, y, heading) = match parts.as_slice() {
        [x, y] => (x, y, None),
        [x, y, heading] => (x, y, Some(heading)),
        _ => {
            return Err(format!(
                "`{text}` is not a pose: give x and y, and the heading if you can: 1.795m -12mm 3deg"
            ));
        }
    };
    Ok(Reading {
        x_m: length(x)?,
        y_m: length(y)?,
        heading_rad: heading.map(|heading| angle(heading)).transpose()?,
    })
}

/// A pose as a person would read it, to the millimetre and the tenth of a degree.
pub(super) fn as_read(pose: sim_target::plant::Pose) -> String {
    let deg = (pose.heading_rad.to_degrees() + 180.0).rem_euclid(360.0) - 180.0;
    // Adding zero turns -0 into 0.
    let mm = |m: f64| (m * 1e3).round() + 0.0;
    let tenth = (deg * 10.0).round() / 10.0 + 0.0;
    format!("{}mm {}mm {tenth}deg", mm(pose.x_m), mm(pose.y_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_length_is_an_offset_and_two_are_the_papers_triangle() {
        let sigma_m = 0.0005;
        match parse_deviation("-36 mm", sigma_m) {
            Ok(Deviation::LateralOffset { y_m, .. }) => assert!((y_m + 0.036).abs() < 1e-12),
            other => panic!("{other:?}"),
        }
        match parse_deviation("2.525 cm, 1mm", sigma_m) {
            Ok(Deviation::Tangent { dx_m, dy_m, .. }) => {
                assert!((dx_m - 0.02525).abs() < 1e-12 && (dy_m - 0.001).abs() < 1e-12);
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn an_answer_without_a_unit_is_asked_again() {
        assert!(parse_deviation("36", 0.0005).is_err());
        assert!(parse_deviation("", 0.0005).is_err());
        assert!(parse_deviation("1mm 2mm 3mm", 0.0005).is_err());
    }

    #[test]
    fn a_pose_takes_units_and_leaves_its_heading_out() {
        let read = parse_pose("1.795 m, -12mm 3deg").unwrap();
        assert!((read.x_m - 1.795).abs() < 1e-12 && (read.y_m + 0.012).abs() < 1e-12);
        assert!((read.heading_rad.unwrap() - 3f64.to_radians()).abs() < 1e-12);
        assert_eq!(parse_pose("1in 0mm").unwrap().heading_rad, None);
        for (bad, why) in [
            ("1.8m", "not a pose"),
            ("1mm 2mm 3deg 4deg", "not a pose"),
            ("1.8 2", "unit"),
            ("1m 2deg", "unit"),
            ("1m 2m 3m", "unit"),
            ("1,795m 2mm", "with a point"),
        ] {
            let said = parse_pose(bad).unwrap_err();
            assert!(said.contains(why) && !said.contains('\n'), "{bad}: {said}");
        }
    }

    #[test]
    fn repeat_skip_and_quit_are_answers_to_the_question_for_the_heading() {
        assert!(matches!(parse_heading("3deg"), Ok(Heading::Read(Some(rad))) if rad > 0.05));
        assert!(matches!(parse_heading(""), Ok(Heading::Read(None))));
        assert!(matches!(parse_heading("Q"), Ok(Heading::Quit)));
        assert!(matches!(parse_heading("skip"), Ok(Heading::Skip)));
        assert!(matches!(parse_heading("r"), Ok(Heading::Repeat)));
        for bad in ["3", "3,5deg", "quite"] {
            assert!(parse_heading(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_pose_as_a_tape_would_read_it_is_understood() {
        let pose = sim_target::plant::Pose { x_m: 1.7949, y_m: -0.0002, heading_rad: 12.5 };
        assert_eq!(as_read(pose), "1795mm 0mm -3.8deg");
        let read = parse_pose(&as_read(pose)).unwrap();
        assert!((read.heading_rad.unwrap() + 3.8f64.to_radians()).abs() < 1e-12);
    }
}
