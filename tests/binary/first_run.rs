//! `beeline` without arguments: the calibration.

use crate::temp_folder::TempFolder;

const PICTURE: &str = "beeline-calibration.html";

#[test]
fn without_arguments_it_calibrates_draws_and_says_what_to_try_next() {
    let temp = TempFolder::new();
    let outcome = temp.run("").ok();
    assert!(outcome.stdout.contains("Drives straight:"), "{outcome:#?}");
    assert!(outcome.stdout.contains(&format!("picture  {PICTURE}")), "{outcome:#?}");
    let (_, next) = outcome.stdout.split_once("What to try next:\n").expect("what to try next");
    assert!(next.lines().count() >= 3, "{next}");
    let picture = String::from_utf8(temp.read(PICTURE)).unwrap();
    assert!(picture.starts_with("<!doctype html>") || picture.starts_with("<!DOCTYPE html>"));
    assert!(picture.contains("<svg") && picture.trim_end().ends_with("</html>"));
    // Nothing else is left behind: no temporary file, no memory of a robot that is gone.
    assert_eq!(temp.listing(), [PICTURE]);
}

#[test]
fn what_it_suggests_to_try_next_works() {
    let temp = TempFolder::new();
    let outcome = temp.run("").ok();
    let (_, next) = outcome.stdout.split_once("What to try next:\n").unwrap();
    let commands: Vec<_> = next
        .lines()
        .filter_map(|line| line.trim().strip_prefix("beeline "))
        .filter_map(|line| line.split("   ").next())
        .collect();
    assert_eq!(commands.len(), 3, "{next}");
    for command in commands.iter().filter(|command| !command.contains("/dev/")) {
        temp.run(command).ok();
    }
}

#[test]
fn what_it_suggests_to_try_next_is_not_what_was_just_done() {
    let temp = TempFolder::new();
    for (done, not, instead) in [
        ("--out-and-back", "--out-and-back", "--runs 4"),
        ("--runs 4", "--runs 4", "--out-and-back"),
        ("--measure ruler --seed 7", "--measure ruler", "--measure camera"),
        ("--measure camera", "--measure camera", "--measure ruler"),
        ("--seed 7", "--seed 7", "--seed 8"),
        ("--flash flash", "--flash flash --out-and-back", "--undo --flash flash"),
    ] {
        let outcome = temp.run(&format!("calibrate {done}")).ok();
        let (result, next) = outcome.stdout.split_once("What to try next:\n").expect("steps");
        assert!(!next.contains(not) && next.contains(instead), "{done}: {next}");
        assert!(!result.contains(&format!("calibrate {done}")), "{done}: {result}");
    }
    let unsure = "calibrate --measure ruler --start-heading 2deg";
    for done in ["--runs 4", "--out-and-back"] {
        let outcome = temp.run(&format!("{unsure} {done}"));
        assert!(!outcome.stderr.contains(&format!("try: {done}")), "{outcome:#?}");
        assert!(!outcome.stderr.contains("four such runs"), "{outcome:#?}");
    }
}

#[test]
fn a_second_run_draws_the_same_picture_byte_for_byte() {
    let temp = TempFolder::new();
    temp.run("").ok();
    let first = temp.read(PICTURE);
    temp.run("").ok();
    assert!(temp.read(PICTURE) == first);
    temp.run("--seed 2").ok();
    assert!(temp.read(PICTURE) != first, "another seed is another throw of the noise");
}

#[test]
fn json_is_one_value_with_the_papers_wheel_weight() {
    let temp = TempFolder::new();
    let outcome = temp.run("--json").ok();
    let value = outcome.json();
    assert_eq!(outcome.stderr, "");
    assert_eq!(value["decision"], "corrected");
    assert_eq!(value["picture"], PICTURE);
    let measured = value["before"]["wheel_weight"]["value"].as_f64().unwrap();
    // The paper's robot has 0.9919; the printed sigma is below 0.0002.
    assert!((measured - 0.9919).abs() < 1e-3, "{measured}");
    let after = value["after"]["lateral_offset_m"].as_f64().unwrap();
    let before = value["before"]["lateral_offset_m"].as_f64().unwrap();
    assert!(after.abs() < before.abs() / 10.0, "{before} m before, {after} m after");
}

#[test]
fn a_pipe_gets_no_colours() {
    let temp = TempFolder::new();
    for arguments in
        ["", "--help", "identify", "ports", "watch --for 50ms", "config set nonsense 1"]
    {
        let outcome = temp.run(arguments);
        let text = outcome.stdout + &outcome.stderr;
        assert!(!text.contains('\u{1b}'), "beeline {arguments}: {text}");
    }
}

#[test]
fn progress_goes_to_standard_error_and_results_to_standard_output() {
    let outcome = TempFolder::new().run("").ok();
    assert!(outcome.stderr.contains("Calibrating"), "{outcome:#?}");
    assert!(!outcome.stdout.contains("Calibrating"), "{outcome:#?}");
    assert!(!outcome.stderr.contains("lateral offset"), "{outcome:#?}");
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let temp = TempFolder::new();
    for arguments in
        ["", "--json", "watch --for 5s", "completions bash", "--help", "sim --scenario"]
    {
        let arguments: Vec<_> = arguments.split_whitespace().collect();
        let mut child = temp.spawn(&arguments);
        // Before it has written a byte, or just after its first ones: neither may matter.
        drop(child.stdout.take());
        let outcome = crate::outcome::collect(child).ok();
        assert!(!outcome.stderr.contains("panicked"), "{arguments:?}: {outcome:#?}");
    }
}

#[test]
fn the_mean_of_four_runs_is_surer_than_one() {
    let temp = TempFolder::new();
    let sigma = |command: &str| {
        temp.run(command).ok().json()["wheel_weight"]["sigma"].as_f64().expect("a number")
    };
    let (one, four) = (sigma("calibrate --json"), sigma("calibrate --runs 4 --json"));
    // Half, but for the tolerance of the track width, which the runs have in common.
    assert!(four > 0.4 * one && four < 0.75 * one, "{four} after {one}");
}

#[test]
fn a_measurement_that_knows_nothing_changes_nothing() {
    let temp = TempFolder::new();
    let arguments = "calibrate --measure ruler --start-heading 2deg --flash flash";
    let outcome = temp.run(arguments);
    assert_eq!(outcome.code, Some(1), "{outcome:#?}");
    assert!(outcome.stderr.contains("cannot tell"), "{outcome:#?}");
    assert!(outcome.stdout.is_empty(), "{outcome:#?}");
    assert_eq!(temp.listing(), Vec::<String>::new());

    let outcome = temp.run(&format!("{arguments} --json"));
    assert_eq!(outcome.code, Some(1), "{outcome:#?}");
    let value = outcome.json();
    assert_eq!(value["decision"], "cannot_tell", "{value}");
    assert_eq!(value["exit_code"], 1);
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let half_width = 1.96 * number(&value["wheel_weight"]["sigma"]);
    // The interval contains 1, so it cannot tell.
    assert!((number(&value["wheel_weight"]["value"]) - 1.0).abs() < half_width, "{value}");
    assert!(value["after"].is_null() && value["picture"].is_null(), "{value}");
}

#[test]
fn what_would_help_most_is_always_said() {
    let temp = TempFolder::new();
    for measure in ["camera", "ruler"] {
        for seed in 1..=6 {
            let outcome = temp.run(&format!("calibrate --seed {seed} --measure {measure}")).ok();
            let said = outcome.stdout.contains(" % of the variance comes from the ");
            assert!(said, "seed {seed}, {measure}: {outcome:#?}");
        }
    }
    // The advice is about one run by itself.
    for several in ["--runs 2", "--out-and-back"] {
        let outcome = temp.run(&format!("calibrate {several}")).ok();
        assert!(!outcome.stdout.contains("of the variance"), "{several}: {outcome:#?}");
    }
}

#[test]
fn the_page_states_the_wheel_weight_that_was_written() {
    let temp = TempFolder::new();
    for (several, drives) in [("--runs 4", 5), ("--out-and-back", 3)] {
        let value = temp.run(&format!("calibrate {several} --json")).ok().json();
        let number = |name: &str| value["wheel_weight"][name].as_f64().expect("a number");
        let written = host_cli::quantity::plus_minus(number("value"), number("sigma"));
        assert_eq!(value["drives"], drives, "{value}");
        let page = String::from_utf8(temp.read(PICTURE)).unwrap();
        assert!(
            page.contains(&format!("Written: W<sub>T</sub> = {written}")),
            "{several} {written}"
        );
        assert!(page.contains(&format!("Driven {drives} times")), "{several}");
    }
}

#[test]
fn the_page_shows_what_is_said() {
    let page = include_str!("../../docs/calibrate.md");
    let (_, sample) = page.split_once("```text\nCalibrating").expect("a sample");
    let (sample, _) = sample.split_once("\n```").expect("its end");
    let said = TempFolder::new().run("").ok().stderr;
    assert_eq!(
        format!("Calibrating{sample}"),
        said.trim_end(),
        "put what is said into docs/calibrate.md"
    );
}
