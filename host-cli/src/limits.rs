//! Which motions are refused before they are commanded: those that the robot would refuse
//! ([`host_link::limits`]), and those that a user hardly means.
//!
//! The robot checks each motion itself; its answer is what counts.

use std::f64::consts::FRAC_PI_2;

use host_link::limits;
use host_link::motion::Motion;
use shared_proto::{Config, Readable};

use crate::calibrate::plausibility::DIFFERENCE_USUAL;
use crate::error::{Error, Result};
use crate::quantity::LengthUnit;

/// A longer drive is more likely a typing error than meant \[s\]: the paper's run takes 20 s, and
/// 60 m at its speed take this long.
pub const DURATION_S_USUAL: f64 = 600.0;

/// Refuses what the robot would refuse, and what takes longer than [`DURATION_S_USUAL`] unless
/// `long`.
pub fn check(motion: &Motion, config: &Config, long: bool) -> Result<()> {
    limits::check(motion, config).map_err(host_link::Error::BeyondLimits)?;
    let duration_s = motion.duration_s();
    if duration_s > DURATION_S_USUAL && !long {
        return Err(Error::new(format_args!("this drive takes {}", time(duration_s)))
            .hint("use a higher --cruise or --acceleration; --long drives it anyway"));
    }
    Ok(())
}

/// Refuses a straight line that is too short or too long for its end to determine W_T.
///
/// On a short line the rounding of a count, q of s metres, changes W_T by more than
/// [`DIFFERENCE_USUAL`]. On a long line, wheels that differ by a share d turn the robot by
/// alpha = s d / b on s metres. From a quarter turn on, two W_T have the same tangent and soon the
/// same offset, so alpha must be less for [`DIFFERENCE_USUAL`].
pub fn check_distance(motion: &Motion, config: &Config) -> Result<()> {
    let length_m = motion.distance.left.abs() * limits::unit_m(motion, config);
    let encoder = config.encoder;
    let count_m = encoder.map(|encoder| config.meters_per_count(&encoder));
    let length_m_min = count_m.left.max(count_m.right) / DIFFERENCE_USUAL;
    if length_m < length_m_min {
        return Err(Error::new(format_args!(
            "{} mm is too short to determine W_T: one encoder count is more than {:.0} % of the distance",
            Readable(length_m * 1e3),
            100.0 * DIFFERENCE_USUAL
        ))
        .hint(format_args!("a metre or two; at least {:.0} mm", (length_m_min * 1e3).ceil())));
    }
    check_length(length_m, config.geometry.track_width_m)
}

/// The upper limit of [`check_distance`], for a robot with this track width \[m\].
pub fn check_length(length_m: f64, track_width_m: f64) -> Result<()> {
    let length_m_max = FRAC_PI_2 * track_width_m / DIFFERENCE_USUAL;
    if length_m <= length_m_max {
        return Ok(());
    }
    Err(Error::new(format_args!(
        "{} m is too far to determine W_T: wheels that differ by {:.0} % would turn the robot by more than a quarter on the way",
        Readable((length_m * 10.0).round() / 10.0),
        100.0 * DIFFERENCE_USUAL
    ))
    .hint(format_args!(
        "at most {:.1} m with a track of {}",
        (length_m_max * 10.0).floor() / 10.0,
        LengthUnit::Cm.format(track_width_m, 1)
    )))
}

/// Refuses a square that is smaller than the robot.
pub fn check_square(side_m: f64, config: &Config) -> Result<()> {
    let track_m = config.geometry.track_width_m;
    if side_m >= track_m {
        return Ok(());
    }
    let cm = |value_m| LengthUnit::Cm.format(value_m, 1);
    Err(Error::new(format_args!(
        "a square of {} is smaller than the robot: its track width is {}",
        cm(side_m),
        cm(track_m)
    ))
    .hint("--side 1m, or larger"))
}

/// A time as people say it: `42 min`, `5 h 2 min`.
fn time(s: f64) -> String {
    let minutes = (s / 60.0).round();
    if minutes < 60.0 {
        return format!("{minutes} min");
    }
    format!("{} h {} min", (minutes / 60.0).floor(), minutes % 60.0)
}

#[cfg(test)]
mod tests {
    use shared_proto::TravelUnit;

    use super::*;

    fn refused_for(motion: Motion) -> String {
        check(&motion, &Config::default(), false).unwrap_err().to_string()
    }

    #[test]
    fn a_drive_of_hours_needs_the_long_option() {
        let slow = Motion { cruise: 0.0001, unit: TravelUnit::Meter, ..Motion::PAPER };
        assert!(refused_for(slow).contains("22 h 13 min"), "{}", refused_for(slow));
        check(&slow, &Config::default(), true).unwrap();
        let hour = Motion { cruise: 8.0 / 3570.0, ..Motion::PAPER };
        assert!(refused_for(hour).contains("1 h 0 min"), "{}", refused_for(hour));
    }
}
