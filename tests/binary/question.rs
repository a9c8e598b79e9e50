//! `beeline calibrate --measure ask`: a person answers.

use crate::outcome::Outcome;
use crate::temp_folder::TempFolder;

fn calibrate(temp: &TempFolder, answers: &str) -> Outcome {
    temp.run_with(&["calibrate", "--measure", "ask", "--flash", "flash"], answers)
}

/// W_T as the robot has it afterwards.
fn wheel_weight(temp: &TempFolder) -> f64 {
    let value = temp.run("config get geometry.wheel_weight --json --flash flash").ok().json();
    value.as_f64().unwrap()
}

#[test]
fn an_offset_typed_in_calibrates() {
    let temp = TempFolder::new();
    // Line up, -36 mm; line up, straight.
    let outcome = calibrate(&temp, "\n-36mm\n\n0.5mm\n").ok();
    assert!(outcome.stdout.contains("Drives straight:"), "{outcome:#?}");
    assert!(outcome.stderr.contains("start line"), "{outcome:#?}");
    // The paper's 0.9919 within the sigma of a ruler, 0.0008.
    assert!((wheel_weight(&temp) - 0.9919).abs() < 1e-3, "{}", wheel_weight(&temp));
}

#[test]
fn the_papers_triangle_typed_in_gives_the_papers_wheel_weight() {
    let temp = TempFolder::new();
    calibrate(&temp, "\n2.525cm 1mm\n\n2.525cm 0mm\n").ok();
    assert!((wheel_weight(&temp) - 0.9919).abs() < 5e-5, "{}", wheel_weight(&temp));
}

#[test]
fn nonsense_is_asked_again() {
    let temp = TempFolder::new();
    let answers = "\nwhat?\n36\n1mm 2mm 3mm\n-36mm\n\n0.5mm\n";
    let outcome = calibrate(&temp, answers).ok();
    let warnings = outcome.stderr.matches("warning:").count();
    assert_eq!(warnings, 3, "{outcome:#?}");
    assert!((wheel_weight(&temp) - 0.9919).abs() < 1e-3);
}

#[test]
fn yes_skips_the_question_whether_the_robot_stands_at_its_line() {
    let temp = TempFolder::new();
    let arguments = ["calibrate", "--measure", "ask", "--yes", "--flash", "flash"];
    temp.run_with(&arguments, "-36mm\n0.5mm\n").ok();
    assert!((wheel_weight(&temp) - 0.9919).abs() < 1e-3);
}

#[test]
fn when_nobody_answers_any_more_nothing_is_changed() {
    for answers in ["", "\n", "\n-36mm\n", "\n-36mm\n\n"] {
        let temp = TempFolder::new();
        temp.run("config set geometry.wheel_weight 0.99 --save --flash flash").ok();
        let flash = temp.read("flash");
        let message = calibrate(&temp, answers).refused();
        assert!(
            message.contains("there is nobody to answer the question"),
            "{answers:?}: {message}"
        );
        assert_eq!(temp.read("flash"), flash, "{answers:?}");
        assert_eq!(temp.listing(), ["flash"], "{answers:?}");
    }
}

#[test]
fn a_reading_that_no_robot_can_have_is_asked_again() {
    let temp = TempFolder::new();
    let outcome = calibrate(&temp, "\n-1.5m\n-36mm\n\n0.5mm\n").ok();
    assert!(outcome.stderr.contains("warning: a lateral offset of -1.5 m"), "{outcome:#?}");
    assert!((wheel_weight(&temp) - 0.9919).abs() < 1e-3);
}

#[test]
fn an_unbelievable_wheel_weight_is_refused_and_nothing_is_changed() {
    let temp = TempFolder::new();
    temp.run("config save --flash flash").ok();
    let flash = temp.read("flash");
    // Within reach, and far outside geometry.wheel_weight's range.
    let message = calibrate(&temp, "\n-0.9m\n").refused();
    assert!(message.contains("implausible"), "{message}");
    assert_eq!(temp.read("flash"), flash);
    assert_eq!(temp.listing(), ["flash"]);
}

#[test]
fn a_new_wheel_weight_that_makes_it_worse_is_taken_back() {
    let temp = TempFolder::new();
    temp.run("config save --flash flash").ok();
    let flash = temp.read("flash");
    let outcome = calibrate(&temp, "\n-36mm\n\n-72mm\n");
    assert_eq!(outcome.code, Some(1), "the answer is no: {outcome:#?}");
    assert!(outcome.stderr.contains("did not reduce the error"), "{outcome:#?}");
    assert_eq!(temp.read("flash"), flash);
    assert_eq!(temp.listing(), ["flash"]);
}

#[test]
fn a_millimetre_less_is_not_straight_and_is_taken_back() {
    let temp = TempFolder::new();
    temp.run("config save --flash flash").ok();
    let flash = temp.read("flash");
    let outcome = calibrate(&temp, "\n-36mm\n\n-35mm\n");
    assert_eq!(outcome.code, Some(1), "the answer is no: {outcome:#?}");
    assert!(!outcome.stdout.contains("Drives straight"), "{outcome:#?}");
    assert!(
        outcome.stderr.contains("did not reduce the error (36.0 mm off before, 35.0 mm after)"),
        "{outcome:#?}"
    );
    assert_eq!(temp.read("flash"), flash);
    assert_eq!(temp.listing(), ["flash"]);
}

#[test]
fn a_no_has_its_numbers_for_machines() {
    let temp = TempFolder::new();
    let arguments = ["calibrate", "--json", "--measure", "ask", "--flash", "flash"];
    let outcome = temp.run_with(&arguments, "\n-36mm\n\n-35mm\n");
    assert_eq!(outcome.code, Some(1), "{outcome:#?}");
    let value = outcome.json();
    assert_eq!(value["decision"], "not_better", "{value}");
    assert_eq!(value["exit_code"], 1);
    assert!(
        value["error"].as_str().is_some_and(|error| error.contains("did not reduce the error")),
        "{value}"
    );
    for (which, offset_m) in [("before", -0.036), ("after", -0.035)] {
        let read_m = value[which]["lateral_offset_m"].as_f64().expect("a number");
        assert!((read_m - offset_m).abs() < 1e-12, "{value}");
    }
    assert!(value["picture"].is_null());
}

#[test]
fn both_ways_are_read_in_the_same_way() {
    let both = |answers: &str| {
        let temp = TempFolder::new();
        let arguments = ["calibrate", "--measure", "ask", "--out-and-back", "--flash", "flash"];
        let outcome = temp.run_with(&arguments, answers).ok();
        (wheel_weight(&temp), outcome.stderr.matches("warning:").count())
    };
    // Line up, out; back (nobody touches it); line up, out with the new W_T. A robot with unequal
    // wheels comes back to its line.
    let (by_offset, warnings) = both("\n-36mm\n30cm 0mm\n0mm\n\n0.5mm\n");
    assert_eq!(warnings, 1, "an angle after an offset");
    assert!((by_offset - 0.9919).abs() < 1e-3, "{by_offset}");
    let (by_angle, warnings) = both("\n30cm 12mm\n0mm\n30cm 0mm\n\n30cm 0mm\n");
    assert_eq!(warnings, 1, "an offset after an angle");
    // 1 - b / (R phi) 0.04 = 0.99178.
    assert!((by_angle - 0.99178).abs() < 1e-4, "{by_angle}");
}
