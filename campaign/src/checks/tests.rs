//! What is said of one short run, in which something was made wrong.

use std::fs;

use crate::error::{CampaignError, Warning};
use crate::recorded::Campaign;

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
    let csv = format!("t_s,right_counts,left_counts,heading_rad,x_m,y_m\n{}\n", rows.join("\n"));
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
    let [right, left] = [1.0, -1.0].map(|side| (0.1 * t_s + side * 0.186 * heading_rad) * per_m);
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
    let same = |value: f64| value;
    assert_eq!(read(|t_s| row(t_s, [1.0; 3], same)).unwrap(), []);
    for (units, expected) in [
        ([1e3, 1.0, 1.0], "01_a.csv, line 1, column 5: x_m and y_m look like millimetres"),
        ([1e2, 1.0, 1.0], "01_a.csv, line 1, column 5: x_m and y_m look like centimetres"),
        ([1.0, 57.29578, 1.0], "01_a.csv, line 1, column 4: heading_rad looks like degrees"),
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
    assert!(error.contains("its 16-bit counter wrapped around"), "{error}");
    assert!(error.ends_with("; add 65536 from this row on"), "{error}");
}

#[test]
fn a_robot_that_is_another_than_its_file_says_is_told_with_the_line_of_the_key() {
    let same = |value: f64| value;
    for (from, to, expected) in [
        ("= 900", "= 225", "line 2, column 1: by the poses, the robot moved 0.25"),
        ("= 0.372", "= 3.72", "line 3, column 1: by the poses, the robot turned "),
    ] {
        let toml = TOML.replace(from, to);
        assert_ne!(toml, TOML);
        let error = read_as(&toml, |t_s| row(t_s, [1.0; 3], same)).unwrap_err().to_string();
        assert!(error.contains(expected) && error.contains("; check"), "{error}");
    }
    // Headings as of one who looks from below, and a frame that is turned round.
    let error = read(|t_s| row(t_s, [1.0, -1.0, 1.0], same)).unwrap_err().to_string();
    assert!(error.contains("column 4: heading_rad counts clockwise"), "{error}");
    let error = read(|t_s| row(t_s, [-1.0, 1.0, 1.0], same)).unwrap_err().to_string();
    assert!(error.contains("heading_rad is turned (") && error.contains("180 degrees"), "{error}");
}

#[test]
fn an_end_that_was_misread_is_a_warning_at_its_cell() {
    let misread = |t_s: f64| {
        let row = row(t_s, [1.0; 3], |value| value);
        let cells: Vec<&str> = row.split(',').collect();
        let heading: f64 = cells[3].parse().unwrap();
        let heading = if t_s > 9.95 { heading + 1.57 } else { heading };
        format!("{},{},{},{heading},{},{}", cells[0], cells[1], cells[2], cells[4], cells[5])
    };
    let warnings = read(misread).unwrap();
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    let said = warning.to_string();
    assert!(said.contains("01_a.csv, line 102, column 4: the run ends 90 degrees off"), "{said}");
}

#[test]
fn a_clock_in_a_smaller_unit_is_a_warning() {
    for (per_s, unit) in [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")] {
        let warnings = read(|t_s| row(t_s, [1.0, 1.0, per_s], |value| value)).unwrap();
        let [warning] = &warnings[..] else { panic!("{warnings:?}") };
        let said = warning.to_string();
        assert!(said.contains(&format!("line 1, column 1: t_s looks like {unit}")), "{said}");
    }
}

#[test]
fn a_clock_that_jumps_is_an_error_at_its_row() {
    let at_half = |jump_s: f64| {
        move |t_s: f64| {
            let row = row(t_s, [1.0; 3], |value| value);
            let (_, rest) = row.split_once(',').unwrap();
            format!("{},{rest}", if t_s > 4.95 { t_s + jump_s } else { t_s })
        }
    };
    for (jump_s, said) in [(5.0, "5.1 s"), (1800.0, "1800.1 s"), (1.7e9, "1.7e9 s")] {
        let error = read(at_half(jump_s)).unwrap_err().to_string();
        let expected = format!("01_a.csv, line 52, column 1: t_s jumps by {said} from the row");
        assert!(error.contains(&expected) && error.contains("cut the run there"), "{error}");
    }
}
