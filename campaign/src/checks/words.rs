//! The errors that are places of a campaign's data: where, what, with which evidence, and what to do.

use std::f64::consts::{FRAC_PI_2, PI};
use std::mem::discriminant;
use std::path::Path;

use robot_model::checks::{Axes, DataFault, DataHypothesis, Wheel};

use super::place::{FaultPlaces, line};
use crate::error::{CampaignError, Place};
use crate::recorded::Campaign;
use crate::row::Column;

/// An error that names the best hypothesis of all that were found.
pub(super) fn error(
    folder: &Path,
    campaign: &Campaign,
    found: &DataHypothesis,
    all: &[DataHypothesis],
) -> CampaignError {
    let places = FaultPlaces::new(folder, campaign, found);
    let (place, what) = of_moment(&places, &found.what)
        .unwrap_or_else(|| (place(&places, &found.what), of_column(&found.what)));
    let (mut problem, hint) = what;
    for other in &found.or {
        problem = format!("{problem}, or {}", of_column(other).0);
    }
    let alike = |other: &&DataHypothesis| discriminant(&other.what) == discriminant(&found.what);
    let others = match all.iter().filter(alike).count() {
        0 | 1 => String::new(),
        2 => " and another run".to_owned(),
        count => format!(" and {} other runs", count - 1),
    };
    let whose = match &found.run {
        Some(run) if campaign.runs.len() > 1 => format!("in run {run}{others}: "),
        None if campaign.runs.len() > 1 => "in all runs: ".to_owned(),
        _ => String::new(),
    };
    CampaignError::new(place, format!("{whose}{problem} ({})", evidence(found)), hint)
}

/// `wheels and poses differ by 0.61 m as they are, by 2 mm with this mended; 0.22 m with the next best explanation`.
fn evidence(found: &DataHypothesis) -> String {
    let next = found.next.map_or(String::new(), |(_, error_m)| {
        format!("; {} with the next best explanation", length(error_m))
    });
    let (before, after) = (length(found.error_m), length(found.mended_m));
    format!("wheels and poses differ by {before} as they are, by {after} with this mended{next}")
}

fn length(value_m: f64) -> String {
    match value_m {
        m if m < 0.0995 => format!("{:.1} mm", 1e3 * m),
        m if m < 9.95 => format!("{m:.2} m"),
        m => format!("{m:.0} m"),
    }
}

pub(super) fn counts(wheel: Wheel) -> Column {
    if wheel == Wheel::Right { Column::RightCounts } else { Column::LeftCounts }
}

/// `left_counts`, `left_counts and right_counts`.
fn columns(wheel: Wheel) -> &'static str {
    match wheel {
        Wheel::Left => "left_counts",
        Wheel::Right => "right_counts",
        Wheel::Both => "left_counts and right_counts",
    }
}

/// Where it shows.
fn place(places: &FaultPlaces, what: &DataFault) -> Place {
    match what {
        DataFault::Radius { .. } | DataFault::Lengths { .. } => places.key("wheel_radius_m"),
        DataFault::Track { .. } => places.key("track_width_m"),
        DataFault::CountsReversed { wheel } | DataFault::Counts { wheel, .. } => {
            places.header(counts(*wheel))
        }
        DataFault::Axes { axes: Axes::YMirrored, .. } => places.header(Column::Y),
        DataFault::Axes { axes: Axes::Heading { .. }, .. } => places.header(Column::Heading),
        DataFault::Axes { .. } | DataFault::Positions { .. } => places.header(Column::X),
        _ => places.header(Column::LeftCounts),
    }
}

/// What happened at a moment: its place, the problem and a hint.
fn of_moment(places: &FaultPlaces, what: &DataFault) -> Option<(Place, (String, String))> {
    let run = places.run?;
    Some(match *what {
        DataFault::CounterWraps { wheel, t_s, bits, times } => {
            let column = counts(wheel);
            let row = line(run, t_s) as usize - 2;
            let before = run.rows[..row].iter().rev().find_map(|row| row.get(column));
            let after = run.rows[row].get(column);
            let (from, to) = (before.unwrap_or(f64::NAN), after.unwrap_or(f64::NAN));
            let often =
                if times > 1 { format!(", {times} times in this run") } else { String::new() };
            let problem = format!(
                "{} goes from {from} to {to} in one step: its {bits}-bit counter wrapped around{often}",
                column.name()
            );
            let verb = if to < from { "add" } else { "subtract" };
            let hint = format!("{verb} {} from this row on", 2_u64.pow(bits));
            (places.cell(t_s, column), (problem, hint))
        }
        DataFault::CounterReset { wheel, t_s } => {
            let restart = if wheel == Wheel::Both { "restart" } else { "restarts" };
            let problem =
                format!("{} {restart} from zero in the middle of the run", columns(wheel));
            let hint = "add what was counted before to this row and all later ones, or split the run into two files here";
            (places.cell(t_s, counts(wheel)), (problem, hint.to_owned()))
        }
        DataFault::TrackerJump { t_s, by_m } => {
            let problem = format!(
                "from the pose before to this one the tracker jumps by {} more than the wheels rolled",
                length(by_m)
            );
            let hint = "split the run into two files here, or clear x_m, y_m and heading_rad from this row on";
            (places.cell(t_s, Column::X), (problem, hint.to_owned()))
        }
        DataFault::TrackerFrozen { from_s, to_s } => {
            let last = line(run, to_s);
            let problem = format!(
                "the tracker is frozen: from here to line {last} ({:.1} s) the pose stays the same while the wheels roll",
                to_s - from_s
            );
            let hint = "clear x_m, y_m and heading_rad in these rows".to_owned();
            (places.cell(from_s, Column::X), (problem, hint))
        }
        _ => return None,
    })
}

/// What is wrong with a column or a key: the problem and a hint.
fn of_column(what: &DataFault) -> (String, String) {
    let both = |problem: &str, hint: &str| (problem.to_owned(), hint.to_owned());
    match *what {
        DataFault::WheelsExchanged => both(
            "left_counts and right_counts are exchanged",
            "swap left_counts and right_counts; if they are right, the poses are mirrored: change the signs of y_m and \
             heading_rad (y is to the left of x, headings are counter-clockwise)",
        ),
        DataFault::CountsReversed { wheel: Wheel::Both } => both(
            "left_counts and right_counts both have the wrong sign",
            "both must increase when the robot drives forwards: change both signs",
        ),
        DataFault::CountsReversed { wheel } => (
            format!("{} has the wrong sign", columns(wheel)),
            format!("it must increase when the robot drives forwards: change the sign of {}", columns(wheel)),
        ),
        DataFault::Counts { wheel, times } => (
            match times > 1.0 {
                true => format!("{} should be {} times as large", columns(wheel), factor(times)),
                false => format!("{} should be {} times smaller", columns(wheel), factor(1.0 / times)),
            },
            "count all encoders alike: four counts per line with quadrature".to_owned(),
        ),
        DataFault::Radius { times } => (
            format!(
                "by the poses, the robot moved {} times as far as this robot.toml makes its wheels roll{}",
                factor(times),
                meaning(times)
            ),
            "check wheel_radius_m (in metres, not the diameter), counts_per_rev (four counts per line with quadrature) \
             and gear_reduction, and that x_m and y_m are in metres"
                .to_owned(),
        ),
        DataFault::Track { times } => (
            format!("by the poses, the robot turned {} times as far as this robot.toml makes its wheels turn it", factor(1.0 / times)),
            "check track_width_m: the distance between the middles of the wheels' treads, in metres".to_owned(),
        ),
        DataFault::Lengths { times } => (
            format!("wheel_radius_m and track_width_m are {} times too large", factor(1.0 / times)),
            "give wheel_radius_m and track_width_m in metres".to_owned(),
        ),
        DataFault::Positions { per_m } => (
            format!("x_m and y_m look like {}", unit(per_m)),
            "give x_m and y_m in metres; if they are, check wheel_radius_m and counts_per_rev in robot.toml".to_owned(),
        ),
        DataFault::Axes { axes, after_first } => {
            let (problem, hint) = of_axes(axes);
            let except = if after_first { ", in all poses except the first of each run" } else { "" };
            (format!("{problem}{except}"), format!("{hint}{except}"))
        }
        _ => both("wheels and poses do not agree", "check the columns of this run"),
    }
}

fn of_axes(axes: Axes) -> (String, String) {
    let both = |problem: &str, hint: &str| (problem.to_owned(), hint.to_owned());
    match axes {
        Axes::XMirrored => both(
            "x_m has the wrong sign",
            "x is forward, y to the left of it: change the sign of x_m",
        ),
        Axes::YMirrored => {
            both("y_m has the wrong sign", "y is to the left of x: change the sign of y_m")
        }
        Axes::Exchanged => both("x_m and y_m are exchanged", "swap x_m and y_m"),
        Axes::Frame { turned_rad } => (
            format!("the axes are turned by {:+.0} degrees", turned_rad.to_degrees()),
            format!("turn x_m, y_m and heading_rad by {:+.0} degrees", -turned_rad.to_degrees()),
        ),
        Axes::Heading { degrees, negated, turned_rad } => {
            let mut said = Vec::new();
            if degrees {
                said.push("looks like degrees".to_owned());
            }
            if negated {
                said.push("counts clockwise".to_owned());
            }
            if turned_rad != 0.0 {
                let from = if negated { "counts from another axis" } else { "is turned" };
                said.push(format!("{from} ({:+.0} degrees)", turned_rad.to_degrees()));
            }
            let value = if degrees { "heading_rad * pi / 180" } else { "heading_rad" };
            let mended = match (negated, angle(-turned_rad)) {
                (false, None) => value.to_owned(),
                (true, None) => format!("-{value}"),
                (true, Some(angle)) => format!("{angle} - {value}"),
                (false, Some(angle)) => match angle.strip_prefix('-') {
                    Some(positive) => format!("{value} - {positive}"),
                    None => format!("{value} + {angle}"),
                },
            };
            let hint = format!(
                "give {mended} in place of heading_rad: in radians, counter-clockwise from x towards y"
            );
            (format!("heading_rad {}", said.join(" and ")), hint)
        }
    }
}

/// `pi/2`, `-pi`, `0.7000`.
fn angle(value_rad: f64) -> Option<String> {
    let sign = if value_rad < 0.0 { "-" } else { "" };
    let is = |other: f64| (value_rad.abs() - other).abs() < 1e-9;
    match value_rad {
        0.0 => None,
        _ if is(FRAC_PI_2) => Some(format!("{sign}pi/2")),
        _ if is(PI) => Some("pi".to_owned()),
        value => Some(format!("{value:.4}")),
    }
}

/// `0.250`, `10.0`.
fn factor(times: f64) -> String {
    if times < 1.0 { format!("{times:.3}") } else { format!("{times:.1}") }
}

/// What a factor of the radius is likely to be.
fn meaning(times: f64) -> &'static str {
    let near = |other: f64| (times / other - 1.0).abs() < 0.06;
    match times {
        _ if near(0.5) => " (a diameter for the radius, or twice the counts)",
        _ if near(0.25) || near(4.0) => " (four counts per line of an encoder)",
        _ if near(PI) || near(2.0 * PI) || near(0.5 / PI) => " (a circumference)",
        _ if near(1e-3) || near(1e3) => " (millimetres)",
        _ => "",
    }
}

fn unit(per_m: f64) -> &'static str {
    match per_m {
        per_m if per_m > 500.0 => "millimetres",
        per_m if per_m > 60.0 => "centimetres",
        per_m if per_m > 10.0 => "inches",
        _ => "feet",
    }
}

/// A clock that jumps.
pub(super) fn clock_jump(place: Place, jump_s: f64) -> CampaignError {
    let jump = if jump_s < 1e6 { format!("{jump_s:.1}") } else { format!("{jump_s:.1e}") };
    let problem = format!("t_s jumps by {jump} s from the row before");
    CampaignError::new(
        place,
        problem,
        "the clock was set, or these are two runs: cut the run there",
    )
}
