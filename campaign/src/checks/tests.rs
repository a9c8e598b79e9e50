use std::f64::consts::FRAC_PI_2;

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
    assert!(error.contains("its 16-bit counter overflowed; add 65536 from this row on"), "{error}");
}

#[test]
fn a_robot_that_is_another_than_its_file_says_is_told_with_the_line_of_the_key() {
    let same = |value: f64| value;
    for (from, to, expected) in [
        ("= 900", "= 225", "line 2, column 1: on straight stretches the robot moved 0.25"),
        ("= 0.372", "= 3.72", "line 3, column 1: the robot turned 10.0"),
    ] {
        let toml = TOML.replace(from, to);
        assert_ne!(toml, TOML);
        let error = read_as(&toml, |t_s| row(t_s, [1.0; 3], same)).unwrap_err().to_string();
        assert!(error.contains(expected) && error.contains("; check"), "{error}");
    }
    // Headings and positions as of one who looks from below.
    let error = read(|t_s| row(t_s, [1.0, -1.0, 1.0], same)).unwrap_err().to_string();
    assert!(error.contains("turned the opposite way") && error.contains("; swap"), "{error}");
    let error = read(|t_s| row(t_s, [-1.0, 1.0, 1.0], same)).unwrap_err().to_string();
    assert!(error.contains("moved backwards where its wheels rolled forwards"), "{error}");
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
fn a_clock_in_milliseconds_is_a_warning() {
    let warnings = read(|t_s| row(t_s, [1.0, 1.0, 1e3], |value| value)).unwrap();
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    let said = warning.to_string();
    assert!(said.contains("line 1, column 1: t_s looks like milliseconds"), "{said}");
}

/// What is said of the mystery robot's runs, the cells of these files rewritten: y_m and heading_rad.
fn of_mystery(files: &str, change: impl Fn(f64, f64) -> (f64, f64)) -> Vec<String> {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/mystery-robot");
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("runs")).unwrap();
    fs::copy(from.join("robot.toml"), folder.path().join("robot.toml")).unwrap();
    for file in fs::read_dir(from.join("runs")).unwrap() {
        let file = file.unwrap();
        let name = file.file_name().into_string().unwrap();
        let text = fs::read_to_string(file.path()).unwrap();
        let mut lines = text.lines();
        let header = lines.next().unwrap();
        let index = |of: Column| header.split(',').position(|name| name == of.name()).unwrap();
        let (y, heading) = (index(Column::Y), index(Column::Heading));
        let mut out = vec![header.to_owned()];
        for line in lines {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            if name.contains(files) && !cells[y].is_empty() {
                let was = (cells[y].parse().unwrap(), cells[heading].parse().unwrap());
                let is = change(was.0, was.1);
                (cells[y], cells[heading]) = (is.0.to_string(), is.1.to_string());
            }
            out.push(cells.join(","));
        }
        fs::write(folder.path().join("runs").join(name), out.join("\n")).unwrap();
    }
    let warnings = Campaign::read(folder.path()).unwrap().warnings;
    warnings.iter().map(Warning::to_string).collect()
}

#[test]
fn other_axes_are_one_warning_that_says_which() {
    assert_eq!(of_mystery("csv", |y, heading| (y, heading)), [""; 0]);
    for (change, expected) in [
        ((|y, heading| (-y, heading)) as fn(f64, f64) -> (f64, f64), "the other sign of y_m (y is"),
        (|y, heading| (y, heading - FRAC_PI_2), "pi/2 added to heading_rad"),
        (|y, heading| (y, heading + FRAC_PI_2), "pi/2 subtracted from heading_rad"),
    ] {
        let said = of_mystery("csv", change);
        assert!(said.len() == 1 && said[0].contains(expected), "{said:?}");
        assert!(said[0].contains("01_rest.csv, line 1, column "), "{said:?}");
    }
}

#[test]
fn headings_that_sit_crooked_in_all_runs_are_one_warning() {
    let said = of_mystery("csv", |y, heading| (y, heading + 0.08));
    assert!(said.len() == 1 && said[0].contains("heading_rad differs by +4."), "{said:?}");
    assert!(said[0].contains("01_rest.csv, line 1, column 9: "), "{said:?}");
}

#[test]
fn one_run_with_other_signs_is_a_warning_at_its_file() {
    let said = of_mystery("16_", |y, heading| {
        (if heading > 3.0 && heading < 3.02 { y + 0.4 } else { y }, heading)
    });
    assert!(
        said.iter().any(|warning| warning.contains("16_arc_large_fast_left.csv, line ")
            && warning.contains(" m off those before and after it")),
        "{said:?}"
    );
    let said = of_mystery("12_", |y, heading| (-y, heading));
    assert!(
        said.len() == 1
            && said[0].contains("12_arc_small_fast_left.csv, line 1, column 7: only in this"),
        "{said:?}"
    );
    // A spin goes nowhere: its headings alone show it.
    let said = of_mystery("06_", |y, heading| (y, -heading));
    assert!(
        said.len() == 1
            && said[0].contains(
                "06_spin_slow_left.csv, line 1: only in this run, the robot turned the opposite way"
            ),
        "{said:?}"
    );
}
