//! Runs whose columns cannot be in the units that they say, in words: what is suspected, and what to do.

use std::fs;
use std::path::Path;

use robot_model::gate::{Mismatch, Suspicion, mismatch, stray, suspicions};
use robot_model::recording::{Recording, Robot};

use super::robot_toml::place_of_key;
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
                let hint = "give heading_rad in radians; if it is, check track_width_m, counts_per_rev and gear_reduction in \
                     robot.toml";
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

/// Refuses a campaign whose wheels and poses cannot be of one robot; no run of it is suspicious.
pub(super) fn check_all(
    folder: &Path,
    robot: &Robot,
    runs: &[Recording],
) -> Result<(), CampaignError> {
    let Some(found) = mismatch(robot, runs) else { return Ok(()) };
    let toml = |key: &str| place_of_key(&folder.join("robot.toml"), key);
    // What is about the columns is so in all runs: the first one stands for them.
    let csv = |column: Column| {
        let name = runs.first().map_or("", |it| it.name.as_str());
        header(&folder.join("runs").join(format!("{name}.csv")), column)
    };
    let fail =
        |place: Place, problem: String, hint: &str| Err(CampaignError::new(place, problem, hint));
    match found {
        Mismatch::Travel { times } => {
            let problem = format!(
                "on straight ways the robot got {} times as far as its wheels rolled by this file",
                factor(times)
            );
            let hint = "check wheel_radius_m (no diameter), counts_per_rev (with quadrature four counts for each \
                        line of the disc) and gear_reduction, and that x_m and y_m are metres";
            fail(toml("wheel_radius_m"), problem, hint)
        }
        Mismatch::Backwards => {
            let problem =
                "in this and all other runs the robot went back where its wheels rolled ahead";
            let hint = "left_counts and right_counts increase when the robot goes ahead: change both signs, \
                        or turn heading_rad by half a turn";
            fail(csv(Column::LeftCounts), problem.to_owned(), hint)
        }
        Mismatch::Turns { times } if times < -0.5 => {
            let problem = "in this and all other runs the robot turned the other way than its wheels turned it";
            let hint = "exchange left_counts and right_counts, or change the sign of heading_rad and y_m: \
                        headings are counter-clockwise, y is to the left of x";
            fail(csv(Column::LeftCounts), problem.to_owned(), hint)
        }
        Mismatch::Turns { times } if times.abs() < STANDS => {
            let problem =
                "in this and all other runs the robot did not turn where its wheels turned it";
            let hint = "one wheel counts backwards: left_counts and right_counts increase when the robot goes ahead";
            fail(csv(Column::LeftCounts), problem.to_owned(), hint)
        }
        Mismatch::Turns { times } => {
            let problem = format!(
                "the robot turned {} times as far as its wheels turned it by this file",
                factor(times.max(0.0))
            );
            let hint = "check track_width_m: from the middle of one wheel's tread to that of the other, in metres";
            fail(toml("track_width_m"), problem, hint)
        }
    }
}

/// Of what its wheels say, a robot that turns by less does not turn.
const STANDS: f64 = 0.02;

/// `0.250`, `10.0`.
fn factor(times: f64) -> String {
    if times < 1.0 { format!("{times:.3}") } else { format!("{times:.1}") }
}

/// Runs whose last pose lies far from where the wheels led; none where that is so throughout.
pub(super) fn stray_ends(folder: &Path, campaign: &Campaign) -> Vec<Warning> {
    let robot = campaign.robot.to_model();
    let recordings: Vec<Recording> = campaign.runs.iter().map(|run| run.to_model(&robot)).collect();
    let sound = |it: &Recording| it.validate().is_ok() && suspicions(&robot, it).is_empty();
    if !recordings.iter().all(sound) || mismatch(&robot, &recordings).is_some() {
        return Vec::new();
    }
    let warning = |(run, recording): (&Run, &Recording)| {
        let found = stray(&robot, recording)?;
        let file = folder.join("runs").join(format!("{}.csv", run.name));
        let line = run.rows.iter().position(|row| row.t_s >= found.t_s)? as u64 + 2;
        let column = if found.position_m.is_some() { Column::X } else { Column::Heading };
        let place = Place { line, ..header(&file, column) };
        Some(Warning::Stray { place, position_m: found.position_m, heading_rad: found.heading_rad })
    };
    let found: Vec<Warning> = campaign.runs.iter().zip(&recordings).filter_map(warning).collect();
    if found.len() > STRAYS_MAX && 4 * found.len() > campaign.runs.len() {
        // So many are not misread.
        let place = place_of_key(&folder.join("robot.toml"), "wheel_radius_m");
        return vec![Warning::Strays { place, runs: found.len(), of: campaign.runs.len() }];
    }
    found
}

/// More than this, and more than a quarter of all runs, are not of a slip of the pen.
const STRAYS_MAX: usize = 2;

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

    const TOML: &str =
        "name = \"r\"\nwheel_radius_m = 0.036\ntrack_width_m = 0.372\ncounts_per_rev = 900\n";

    /// A run that goes 1 m ahead in 10 s, and turns by a quarter: counts of a turn of 36 mm.
    fn read(row: impl Fn(f64) -> String) -> Result<Vec<Warning>, CampaignError> {
        read_as(TOML, row)
    }

    fn read_as(toml: &str, row: impl Fn(f64) -> String) -> Result<Vec<Warning>, CampaignError> {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("runs")).unwrap();
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
    fn a_robot_that_is_another_than_its_file_says_is_told_with_the_line_of_the_key() {
        let same = |it: f64| it;
        for (from, to, expected) in [
            ("= 900", "= 225", "line 2, column 1: on straight ways the robot got 0.25"),
            ("= 0.372", "= 3.72", "line 3, column 1: the robot turned 10.0"),
        ] {
            let toml = TOML.replace(from, to);
            assert_ne!(toml, TOML);
            let error = read_as(&toml, |t_s| row(t_s, [1.0; 3], same)).unwrap_err().to_string();
            assert!(error.contains(expected) && error.contains("; check"), "{error}");
        }
        // Headings and positions as of one who looks from below.
        let error = read(|t_s| row(t_s, [1.0, -1.0, 1.0], same)).unwrap_err().to_string();
        assert!(error.contains("turned the other way") && error.contains("; exchange"), "{error}");
        let error = read(|t_s| row(t_s, [-1.0, 1.0, 1.0], same)).unwrap_err().to_string();
        assert!(error.contains("went back where its wheels rolled ahead"), "{error}");
    }

    #[test]
    fn an_end_that_was_misread_is_a_warning_at_its_cell() {
        let misread = |t_s: f64| {
            let row = row(t_s, [1.0; 3], |it| it);
            let cells: Vec<&str> = row.split(',').collect();
            let heading: f64 = cells[3].parse().unwrap();
            let heading = if t_s > 9.95 { heading + 1.57 } else { heading };
            format!("{},{},{},{heading},{},{}", cells[0], cells[1], cells[2], cells[4], cells[5])
        };
        let warnings = read(misread).unwrap();
        let [warning] = &warnings[..] else { panic!("{warnings:?}") };
        let said = warning.to_string();
        assert!(
            said.contains("01_a.csv, line 102, column 4: the run ends 90 degrees from"),
            "{said}"
        );
    }

    #[test]
    fn a_clock_in_milliseconds_is_a_warning() {
        let warnings = read(|t_s| row(t_s, [1.0, 1.0, 1e3], |it| it)).unwrap();
        let [warning] = &warnings[..] else { panic!("{warnings:?}") };
        let said = warning.to_string();
        assert!(said.contains("line 1, column 1: t_s looks like milliseconds"), "{said}");
    }
}
