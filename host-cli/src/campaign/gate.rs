//! Runs whose columns cannot be in the units that they say, in words: what is suspected, and what to do.

use std::fs;
use std::path::Path;

use robot_model::gate::{Suspicion, suspicions};
use robot_model::recording::{Recording, Robot};

use super::{Campaign, CampaignError, Column, Place, Run, Warning};

/// Refuses a run that no robot can have driven; `file` is where it was read.
pub(super) fn check(
    file: &Path,
    run: &Run,
    robot: &Robot,
    recording: &Recording,
) -> Result<(), CampaignError> {
    let fail = |place: Place, problem: String, hint: &str| {
        Err(CampaignError::new(place, problem, hint.to_owned()))
    };
    for suspicion in suspicions(robot, recording) {
        match suspicion {
            Suspicion::Positions { per_m, measured_m, rolled_m } => {
                let unit = if per_m > 500.0 { "millimetres" } else { "centimetres" };
                let problem = format!(
                    "x_m looks like {unit}: the robot would have moved {measured_m:.0} m where its \
                     wheels rolled {rolled_m:.1} m"
                );
                let hint = "give x_m and y_m in metres; if they are, check wheel_radius_m and \
                            counts_per_rev in robot.toml";
                return fail(header(file, Column::X), problem, hint);
            }
            Suspicion::Headings { measured_rad, turned_rad } => {
                let problem = format!(
                    "heading_rad looks like degrees: the robot would have turned by {measured_rad:.0} \
                     rad where its wheels turned it by {turned_rad:.1} rad"
                );
                let hint =
                    "give heading_rad in radians; if it is, check track_width_m in robot.toml";
                return fail(header(file, Column::Heading), problem, hint);
            }
            Suspicion::WentRound { right, t_s, bits } => {
                let column = if right { Column::RightCounts } else { Column::LeftCounts };
                let row = run.rows.iter().position(|row| row.t_s >= t_s).unwrap_or(0);
                let before = run.rows[..row].iter().rev().find_map(|it| it.get(column));
                let after = run.rows[row].get(column);
                let (from, to) = (before.unwrap_or(f64::NAN), after.unwrap_or(f64::NAN));
                let problem = format!(
                    "{} goes from {from} to {to} in one step: its counter of {bits} bits went round",
                    column.name()
                );
                let hint = format!(
                    "{} {} from this row on",
                    if to < from { "add" } else { "subtract" },
                    2_u64.pow(bits)
                );
                let place = Place { line: row as u64 + 2, ..header(file, column) };
                return fail(place, problem, &hint);
            }
            // Slow robots there are: it is a warning.
            Suspicion::Clock { .. } => {}
        }
    }
    Ok(())
}

/// Runs whose clock can hardly be in seconds.
pub(super) fn slow_clocks(folder: &Path, campaign: &Campaign) -> Vec<Warning> {
    let robot = campaign.robot.to_model();
    let warning = |run: &Run| {
        let recording = run.to_model(&robot);
        recording.validate().ok()?;
        let found = suspicions(&robot, &recording).into_iter();
        let rate_rad_s = found.into_iter().find_map(|it| match it {
            Suspicion::Clock { rate_rad_s } => Some(rate_rad_s),
            _ => None,
        })?;
        let file = folder.join("runs").join(format!("{}.csv", run.name));
        Some(Warning::Clock { place: header(&file, Column::Time), rate_rad_s })
    };
    campaign.runs.iter().filter_map(warning).collect()
}

/// Where a column's name stands; the file as a whole if it cannot be read again.
fn header(file: &Path, column: Column) -> Place {
    let text = fs::read_to_string(file).unwrap_or_default();
    let names = text.lines().next().unwrap_or_default().split(',');
    let name =
        |it: &str| it.trim().trim_start_matches('\u{feff}').trim_matches('"') == column.name();
    match names.into_iter().position(name) {
        Some(index) => Place { line: 1, column: index as u64 + 1, ..Place::whole(file) },
        None => Place::whole(file),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run that goes 1 m ahead in 10 s, and turns by a quarter: counts of a turn of 36 mm.
    fn read(row: impl Fn(f64) -> String) -> Result<Vec<Warning>, CampaignError> {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("runs")).unwrap();
        let toml =
            "name = \"r\"\nwheel_radius_m = 0.036\ntrack_width_m = 0.372\ncounts_per_rev = 900\n";
        fs::write(folder.path().join("robot.toml"), toml).unwrap();
        let rows: Vec<String> = (0..=100).map(|k| row(0.1 * f64::from(k))).collect();
        let csv =
            format!("t_s,right_counts,left_counts,heading_rad,x_m,y_m\n{}\n", rows.join("\n"));
        fs::write(folder.path().join("runs/01_a.csv"), csv).unwrap();
        let campaign = Campaign::read(folder.path())?;
        campaign.to_model(folder.path())?;
        Ok(campaign.warnings)
    }

    /// Metres, radians, counts and seconds of the run at a time, times these.
    fn row(t_s: f64, [metres, radians, seconds]: [f64; 3], counts: impl Fn(f64) -> f64) -> String {
        let heading_rad = 0.157 * t_s;
        let (x_m, y_m) = (0.637 * heading_rad.sin(), 0.637 * (1.0 - heading_rad.cos()));
        let per_m = 900.0 / (std::f64::consts::TAU * 0.036);
        let [right, left] =
            [1.0, -1.0].map(|side| (0.1 * t_s + side * 0.186 * heading_rad) * per_m);
        format!(
            "{},{},{},{},{},{}",
            seconds * t_s,
            right.round(),
            counts(left.round()),
            radians * heading_rad,
            metres * x_m,
            metres * y_m
        )
    }

    #[test]
    fn wrong_units_are_one_error_each_with_their_column() {
        let same = |it: f64| it;
        assert_eq!(read(|t_s| row(t_s, [1.0; 3], same)).unwrap(), []);
        for (units, expected) in [
            (
                [1e3, 1.0, 1.0],
                "01_a.csv, line 1, column 5: x_m looks like millimetres: the robot would have moved",
            ),
            ([1e2, 1.0, 1.0], "line 1, column 5: x_m looks like centimetres"),
            (
                [1.0, 57.29578, 1.0],
                "01_a.csv, line 1, column 4: heading_rad looks like degrees: the robot would have turned",
            ),
        ] {
            let error = read(|t_s| row(t_s, units, same)).unwrap_err().to_string();
            assert!(error.contains(expected) && error.contains("; give"), "{error}");
        }
    }

    #[test]
    fn a_counter_that_went_round_is_told_with_its_row_and_what_to_add() {
        // It begins 50 counts below its end, and is beyond after two seconds or so.
        let round = |left: f64| (left + 65_486.0).rem_euclid(65_536.0);
        let error = read(|t_s| row(t_s, [1.0; 3], round)).unwrap_err().to_string();
        assert!(error.contains("column 3: left_counts goes from 655"), "{error}");
        assert!(error.contains("of 16 bits went round; add 65536 from this row on"), "{error}");
    }

    #[test]
    fn a_clock_in_milliseconds_is_a_warning() {
        let warnings = read(|t_s| row(t_s, [1.0, 1.0, 1e3], |it| it)).unwrap();
        let [warning] = &warnings[..] else { panic!("{warnings:?}") };
        let said = warning.to_string();
        assert!(said.contains("line 1, column 1: t_s looks like milliseconds"), "{said}");
    }
}
