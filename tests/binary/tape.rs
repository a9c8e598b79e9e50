//! `beeline campaign record --measure ask`: a person with a tape measure answers.

use std::f64::consts::FRAC_PI_2;

use campaign::{Campaign, Row};

use crate::outcome::Outcome;
use crate::recorded::only_unequal_wheels;
use crate::temp_folder::TempFolder;

/// There and round, away from its mark.
const PLAN: &str = "\
acceleration_mps2 = 0.3
[[run]]
name = \"ahead\"
pieces = [{ straight_m = 0.5, speed_mps = 0.2 }]
[[run]]
name = \"north\"
heading_deg = 90
pieces = [{ straight_m = 0.5, speed_mps = 0.2 }]
[[run]]
name = \"spin\"
pieces = [{ spin_deg = 360, speed_mps = 0.1 }]
";

const RECORD: [&str; 7] =
    ["campaign", "record", "robot", "--plan", "plan.toml", "--measure", "ask"];

fn temp() -> TempFolder {
    let temp = TempFolder::new();
    temp.write("plan.toml", PLAN);
    temp
}

fn record(temp: &TempFolder, answers: &str) -> Outcome {
    temp.run_with(&RECORD, answers)
}

fn campaign(temp: &TempFolder) -> Campaign {
    Campaign::read(&temp.path("robot")).unwrap()
}

fn names(temp: &TempFolder) -> Vec<String> {
    campaign(temp).runs.into_iter().map(|run| run.name).collect()
}

/// The rows of a run that have a position.
fn seen(temp: &TempFolder, run: usize) -> Vec<Row> {
    campaign(temp).runs[run].rows.iter().filter(|row| row.x_m.is_some()).copied().collect()
}

#[test]
fn both_ends_of_a_run_are_where_the_tape_says_and_bad_answers_are_asked_again() {
    let temp = temp();
    let ahead = "1m\n12mm -3mm 1deg\n500 3\n5m 0m\n50.8cm -4mm 2mm\n50.8cm -4mm\ntwo\n2\n2.5deg\n";
    let outcome = record(&temp, &format!("{ahead}\n0mm 0.497m 91deg\n\n1mm 2mm\n\n")).ok();
    let warnings: Vec<&str> =
        outcome.stderr.lines().filter(|line| line.starts_with("warning:")).collect();
    for (warning, expected) in warnings.iter().zip([
        "`1m` is not a pose",
        "no unit",
        "4.99 m from its start",
        "unit",
        "no number",
        "no unit",
    ]) {
        assert!(warning.contains(expected), "{warning}");
    }
    assert_eq!(warnings.len(), 6, "{outcome:#?}");
    assert_eq!(names(&temp), ["01_ahead", "02_north", "03_spin"]);

    let [start, end] = seen(&temp, 0)[..] else { panic!("{:?}", seen(&temp, 0)) };
    assert_eq!(
        (start.x_m, start.y_m, start.heading_rad),
        (Some(0.012), Some(-0.003), Some(0.0174533))
    );
    assert_eq!((end.x_m, end.y_m, end.heading_rad), (Some(0.508), Some(-0.004), Some(0.0436332)));
    // At rest: at the first sample and the last one.
    let rows = &campaign(&temp).runs[0].rows;
    assert_eq!((start.t_s, end.t_s), (rows[0].t_s, rows[rows.len() - 1].t_s));
    // A run that begins at its mark begins in the mark's heading.
    let [start, end] = seen(&temp, 1)[..] else { panic!("{:?}", seen(&temp, 1)) };
    assert_eq!((start.x_m, start.y_m), (Some(0.0), Some(0.0)));
    assert!((start.heading_rad.unwrap() - FRAC_PI_2).abs() < 1e-7);
    assert_eq!(end.y_m, Some(0.497));
    assert_eq!(seen(&temp, 2)[1].heading_rad, None, "it was left out");
}

#[test]
fn what_the_wheels_contradict_is_asked_again_and_taken_when_typed_twice() {
    let temp = temp();
    let ahead = "\n0.5m 0m 90deg\n0.5m 0m 3deg\n";
    let north = "\n0m -0.5m 90deg\n0m -0.5m 90deg\n";
    let outcome = record(&temp, &format!("{ahead}{north}\n0m 0m 90deg\n0m 0m\n1deg\n")).ok();
    let warnings: Vec<&str> =
        outcome.stderr.lines().filter(|line| line.starts_with("warning:")).collect();
    let [ahead, north, spin] = warnings[..] else { panic!("{outcome:#?}") };
    for (warning, off) in [(ahead, " degrees off"), (north, " m off"), (spin, " degrees")] {
        assert!(warning.contains(off) && warning.contains("read it again"), "{warning}");
    }
    let heading = |run: usize| seen(&temp, run)[1].heading_rad.unwrap();
    assert!((heading(0) - 3_f64.to_radians()).abs() < 1e-6);
    assert_eq!(seen(&temp, 1)[1].y_m, Some(-0.5));
    assert!((heading(2) - 1_f64.to_radians()).abs() < 1e-6);
}

#[test]
fn how_well_a_tape_is_read_is_in_robot_toml_once_it_was_read() {
    let temp = temp();
    // A track has its own noise, and nothing was read by the tape.
    let outcome = record(&temp, "s\ns\ns\n").ok();
    assert!(outcome.stderr.contains("good to 2 mm and 10 mrad"), "{outcome:#?}");
    let text = temp.read("robot/robot.toml");
    assert!(!String::from_utf8(text).unwrap().contains("sigma"));
    record(&temp, "\n0.5m 0m 0deg\ns\ns\n").ok();
    let robot = campaign(&temp).robot;
    assert_eq!((robot.position_sigma_m, robot.heading_sigma_rad), (Some(0.002), Some(0.01)));

    // The first value stays, and another instrument leads to a warning.
    let finer = [&RECORD[..], &["--position-sigma", "0.5mm"]].concat();
    let outcome = temp.run_with(&finer, "\n0m 0.5m 90deg\ns\n").ok();
    assert!(
        outcome.stderr.contains("position_sigma_m = 0.002, but this run was measured with 0.0005"),
        "{outcome:#?}"
    );
    assert_eq!(campaign(&temp).robot.position_sigma_m, Some(0.002));

    let temp = self::temp();
    temp.run_with(&finer, "\n0.5m 0m 0deg\ns\ns\n").ok();
    let robot = campaign(&temp).robot;
    assert_eq!((robot.position_sigma_m, robot.heading_sigma_rad), (Some(0.0005), Some(0.01)));
}

#[test]
fn when_answers_end_what_is_complete_is_kept_and_the_same_command_goes_on() {
    // Before the second run, after it, and while its heading is asked for.
    for rest in ["", "\n", "\n0m 0.5m\n"] {
        let temp = temp();
        let message = record(&temp, &format!("\n0.5m 0m 0deg\n{rest}")).refused();
        assert!(message.contains("there is nobody to answer the question"), "{rest:?}: {message}");
        assert!(message.contains("1 run complete and kept"), "{rest:?}: {message}");
        assert_eq!(names(&temp), ["01_ahead"], "{rest:?}");
        let kept = temp.read("robot/runs/01_ahead.csv");
        assert_eq!(std::fs::read_dir(temp.path("robot/runs")).unwrap().count(), 1);

        let outcome = record(&temp, "\n0m 0.5m 90deg\n\n0m 0m 0deg\n").ok();
        assert!(outcome.stderr.contains("already recorded: 1 run of the plan"), "{outcome:#?}");
        assert_eq!(names(&temp), ["01_ahead", "02_north", "03_spin"]);
        assert_eq!(temp.read("robot/runs/01_ahead.csv"), kept);
    }
    // Said so, after a run: that one is driven again next time.
    let temp = temp();
    let outcome = record(&temp, "\n0.5m 0m 0deg\n\nq\n");
    assert_eq!(outcome.code, Some(130), "{outcome:#?}");
    assert_eq!(names(&temp), ["01_ahead"]);
}

#[test]
fn a_run_is_left_out_or_driven_again_after_it_was_seen_to_go_wrong() {
    let temp = temp();
    let outcome = record(&temp, "\nskip\n\nrepeat\n\n0m 0.5m 90deg\ns\n").ok();
    assert!(outcome.stdout.contains("2 left out: ahead, spin"), "{outcome:#?}");
    assert_eq!(outcome.stderr.matches("north: put the robot").count(), 2, "{outcome:#?}");
    assert_eq!(names(&temp), ["01_north"]);
    assert_eq!(seen(&temp, 0).len(), 2);
    // A run that was left out is asked for again.
    record(&temp, "\n0.5m 0m 0deg\n\n0m 0m 0deg\n").ok();
    assert_eq!(names(&temp), ["01_north", "02_ahead", "03_spin"]);
}

fn squares() -> String {
    let mut plan = String::from("acceleration_mps2 = 0.3\n");
    for number in 1..=3 {
        for (way, deg) in [("left", 90), ("right", -90)] {
            let side = format!(
                "{{ straight_m = 1, speed_mps = 0.25 }}, {{ spin_deg = {deg}, speed_mps = 0.12 }}"
            );
            let sides = [side.as_str(); 4].join(", ");
            plan += &format!("[[run]]\nname = \"{way}_{number}\"\npieces = [{sides}]\n");
        }
    }
    plan
}

/// The tape reads the robot's true pose: the first recording prints what the tape would read, and this is typed in the
/// second time.
#[test]
fn the_ends_of_squares_name_the_class_that_they_cannot_tell_apart() {
    let temp = TempFolder::new();
    temp.write("plan.toml", &squares());
    temp.write("unequal.toml", &only_unequal_wheels());
    let record = |folder: &str, answers: &str| {
        let mut arguments = RECORD.to_vec();
        arguments[2] = folder;
        arguments.extend(["--port", "sim:unequal.toml"]);
        temp.run_with(&arguments, answers).ok()
    };
    let practice = record("practice", &"\n".repeat(12));
    let read: Vec<&str> = practice
        .stderr
        .lines()
        .filter_map(|line| line.trim().strip_prefix("a tape would read "))
        .collect();
    assert_eq!(read.len(), 6, "{practice:#?}");
    let answers: String = read.iter().map(|line| format!("\n{line}\n")).collect();
    record("robot", &answers);
    let compared = temp.run("compare robot").ok().stdout;
    assert!(compared.contains("05_left_3"), "{compared}");
    let answer = temp.run("explain robot --format json").ok().json();
    let classes = answer["steps"].as_array().unwrap();
    let class = classes
        .iter()
        .map(|step| &step["class"])
        .find(|class| class.as_array().unwrap().iter().any(|id| id == "wheel_radius_ratio"));
    let class = class.unwrap_or_else(|| panic!("{answer:#}"));
    for id in ["heading_pull", "turn_asymmetry"] {
        assert!(class.as_array().unwrap().iter().any(|member| member == id), "{answer:#}");
    }
    assert!(!answer["next_run"].is_null(), "{answer:#}");
    // The same robot has to drive the next run.
    let said = temp.run("explain robot").ok().stdout;
    let next = said.lines().find(|line| line.contains("beeline campaign record robot --run"));
    assert!(next.is_some_and(|command| command.ends_with(" --port sim:unequal.toml")), "{said}");
}

#[test]
fn a_run_that_is_suggested_may_follow_at_once() {
    let temp = temp();
    record(&temp, "\n49.8cm 1mm 0deg\nq\n");
    // The suggested command measures with the tape, too, and is followed within the same minute.
    temp.run("explain robot").ok();
    let once_more = |answers: &str| {
        let straight = ["campaign", "record", "robot", "--run", "straight", "--measure", "ask"];
        temp.run_with(&straight, answers).ok();
    };
    once_more("\n1.498m 2mm 0deg\n");
    once_more("\n1.498m 1mm 0deg\n");
    assert_eq!(names(&temp).len(), 3);
}
