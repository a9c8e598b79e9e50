//! The nominal robot: its numbers as the user gives them, else from how far the robot went and turned.

use std::f64::consts::{PI, TAU};

use campaign::{CampaignError, RobotFile};

use super::hints::Hints;
use crate::alignment::Alignment;
use crate::log::{PoseLog, WheelLog, WheelUnit, error};

/// Of a wheel, if it was estimated \[m\].
const RADII_M: std::ops::RangeInclusive<f64> = 0.005..=1.0;

/// Turns the wheels' numbers into radians; how many counts a revolution has in the campaign.
pub(super) fn in_radians(wheels: &mut WheelLog, hints: &Hints) -> Result<f64, CampaignError> {
    let gear = hints.gear_reduction.unwrap_or(1.0);
    let (rad_per_unit, counts_per_rev) = match wheels.unit {
        // Any number of counts would do; a campaign that exists has one.
        WheelUnit::Radians => (1.0, hints.counts_per_rev.unwrap_or(TAU / gear)),
        WheelUnit::Counts => {
            let Some(counts) = hints.counts_per_rev else {
                let problem = format!(
                    "the wheels ({}) are in counts, and how many make a turn is unknown",
                    wheels.what
                );
                let hint = "add --counts-per-rev N, and --gear-reduction N if the encoder is on the motor; or map angles: --map left_rad=...,right_rad=...";
                return Err(error(&wheels.file, problem, hint));
            };
            (TAU / (counts * gear), counts)
        }
        WheelUnit::Metres => {
            let Some(radius_m) = hints.wheel_radius_m else {
                let problem = format!(
                    "the wheels ({}) are in metres rolled, and their radius is unknown",
                    wheels.what
                );
                return Err(error(
                    &wheels.file,
                    problem,
                    "add --wheel-radius, the one that the logger used",
                ));
            };
            (1.0 / radius_m, hints.counts_per_rev.unwrap_or(TAU / gear))
        }
    };
    for turned in &mut wheels.turned {
        *turned = turned.map(|number| number * rad_per_unit);
    }
    wheels.unit = WheelUnit::Radians;
    Ok(counts_per_rev)
}

/// A unit is certain if going and turning agree on it so well.
const UNIT_AGREES: f64 = 0.05;

/// In what the wheels are, and what makes radians of it, if that is certain: by the radius and the track width that the user gave.
pub(super) fn unit(alignment: &Alignment, hints: &Hints) -> Option<(&'static str, f64)> {
    let (radius_m, width_m) = (hints.wheel_radius_m?, hints.track_width_m?);
    let by_travel = alignment.travel_per_unit? / radius_m;
    let by_turn = alignment.turn_per_unit? * width_m / radius_m;
    let units = [("degrees", PI / 180.0), ("turns", TAU), ("metres", 1.0 / radius_m)];
    units.into_iter().find(|(_, rad)| {
        [by_travel, by_turn].iter().all(|found| (found / rad - 1.0).abs() < UNIT_AGREES)
            // A radius of a metre: both are the same.
            && (rad - 1.0).abs() > 2.0 * UNIT_AGREES
    })
}

/// Units of positions in a metre: millimetres, centimetres, inches, feet.
const PER_M: [f64; 4] = [1000.0, 100.0, 1.0 / 0.0254, 1.0 / 0.3048];
/// A radius on paper is seldom further off.
const RADIUS_AGREES: f64 = 0.25;

/// How many of the poses' units make a metre, by the radius that the user gave: before they are converted, with the whole evidence.
pub(super) fn units_per_m(alignment: &Alignment, hints: &Hints) -> f64 {
    let found = alignment.travel_per_unit.zip(hints.wheel_radius_m).map(|(unit, m)| unit / m);
    let agrees =
        |per_m: &f64| found.is_some_and(|found| (found / per_m - 1.0).abs() < RADIUS_AGREES);
    PER_M.into_iter().find(agrees).unwrap_or(1.0)
}

/// The nominal robot: as the user says, else from how far it went.
pub(super) fn robot(
    wheels: &WheelLog,
    poses: &PoseLog,
    hints: &Hints,
    counts_per_rev: f64,
    alignment: &Alignment,
) -> Result<(RobotFile, [bool; 2]), CampaignError> {
    let estimated_m = alignment.travel_per_unit;
    let wheel_radius_m = match (hints.wheel_radius_m, estimated_m) {
        (Some(radius_m), _) => radius_m,
        (None, Some(estimated_m)) if RADII_M.contains(&estimated_m) => rounded(estimated_m),
        (None, None) => {
            let problem = "the radius of the wheels is unknown, and the robot only turned";
            return Err(error(&wheels.file, problem, "add --wheel-radius"));
        }
        (None, Some(estimated_m)) => {
            let problem =
                format!("by the poses, the wheels would have a radius of {estimated_m:.4} m");
            let hint = "give the unit of the poses, as in --map x_m=COLUMN:mm,y_m=COLUMN:mm, or --wheel-radius and --track-width, by which the units of the wheels are found";
            return Err(error(&poses.file, problem, hint));
        }
    };
    // theta = R (phi_r - phi_l) / b
    let width_m =
        alignment.turn_per_unit.filter(|turn| *turn > 0.0).map(|turn| wheel_radius_m / turn);
    let track_width_m = match (hints.track_width_m, width_m) {
        (Some(width_m), _) => width_m,
        (None, Some(width_m)) => rounded(width_m),
        (None, None) => {
            let problem = "the track width is unknown, and no turn of the robot was measured";
            return Err(error(&wheels.file, problem, "add --track-width"));
        }
    };
    let name = hints.name.clone().unwrap_or_else(|| "imported robot".into());
    let robot = RobotFile {
        name,
        wheel_radius_m,
        track_width_m,
        counts_per_rev,
        gear_reduction: hints.gear_reduction.unwrap_or(1.0),
        ..RobotFile::default()
    };
    Ok((robot, [hints.wheel_radius_m.is_none(), hints.track_width_m.is_none()]))
}

/// Four digits: more are not known.
fn rounded(value: f64) -> f64 {
    let digits = 3 - value.abs().log10().floor() as i32;
    let power = 10_f64.powi(digits);
    (value * power).round() / power
}
