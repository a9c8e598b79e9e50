//! `beeline wheel-weight`: the paper's calculation on numbers typed in.

use crate::temp_folder::TempFolder;

#[test]
fn the_papers_numbers_give_the_papers_result() {
    let outcome = TempFolder::new().run("wheel-weight --dx 2.525cm --dy 1mm").ok();
    for expected in ["0.9919", "3.5707 cm", "0.0041"] {
        assert!(outcome.stdout.contains(expected), "{expected} in\n{}", outcome.stdout);
    }
}

#[test]
fn json_has_the_same_numbers() {
    let value = TempFolder::new().run("wheel-weight --dx 2.525cm --dy 1mm --json").ok().json();
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    // As many digits as the paper prints.
    assert!((number(&value["wheel_weight"]["value"]) - 0.9919).abs() < 5e-5, "{value}");
    assert!((number(&value["wheel_weight"]["sigma"]) - 0.0041).abs() < 5e-5, "{value}");
    assert!((number(&value["right_radius_m"]) - 0.035707).abs() < 5e-7, "{value}");
}

#[test]
fn units_are_read_not_guessed() {
    let temp = TempFolder::new();
    let same = [
        "wheel-weight --dx 2.525cm --dy 1mm",
        "wheel-weight --dx 25.25mm --dy 0.1cm",
        "wheel-weight --dx 0.02525m --dy 1000um",
        "wheel-weight --dx 2.525e-2m --dy 0.001m --radius 36mm --track-width 0.372m",
    ];
    let first = temp.run(same[0]).ok().stdout;
    for arguments in same {
        assert_eq!(temp.run(arguments).ok().stdout, first, "{arguments}");
    }
}

#[test]
fn an_offset_to_the_left_and_a_tangent_to_the_right_have_opposite_signs() {
    let temp = TempFolder::new();
    let value = |arguments: &str| {
        temp.run(arguments).ok().json()["wheel_weight"]["value"].as_f64().unwrap()
    };
    assert!(value("wheel-weight --json --dx 2.525cm --dy 1mm") < 1.0);
    assert!(value("wheel-weight --json --dx 2.525cm --dy -1mm") > 1.0);
    assert!(value("wheel-weight --json --lateral -36mm") < 1.0);
    assert!(value("wheel-weight --json --lateral 36mm") > 1.0);
}

#[test]
fn a_number_without_a_unit_or_with_a_strange_one_is_refused() {
    let temp = TempFolder::new();
    for (arguments, expected) in [
        ("wheel-weight --dx 2.525 --dy 1mm", "`2.525` has no unit"),
        ("wheel-weight --dx 2.525cm --dy 1furlong", "`furlong`"),
        ("wheel-weight --dx 2.525cm --dy cm", "no number"),
        ("wheel-weight --dx 2.525cm --dy 1s", "not a unit of length"),
        ("wheel-weight --dx 0cm --dy 1mm", "dx"),
        ("wheel-weight --dx 2.525cm", "--dy"),
        ("wheel-weight", "--lateral"),
        ("wheel-weight --dx 1cm --dy 1mm --lateral 1mm", "cannot be used with"),
        ("wheel-weight --lateral 1mm --sigma -1mm", "must not be negative"),
        ("wheel-weight --lateral 1mm --radius 0m", "must be above zero"),
        ("wheel-weight --lateral 1mm --track-width -1m", "must be above zero"),
        ("wheel-weight --lateral 1mm --revolutions 0", "did not turn"),
        ("wheel-weight --lateral 1mm --revolutions NaN", "NaN"),
        (
            "wheel-weight --lateral 1mm --counts-per-rev 0 --left-counts 1 --right-counts 1",
            "counts",
        ),
        ("wheel-weight --lateral 1e308km", "too large"),
    ] {
        let message = temp.run(arguments).refused();
        assert!(message.contains(expected), "{arguments}: {message}");
    }
}

#[test]
fn counts_of_a_run_backwards_are_read() {
    let temp = TempFolder::new();
    let by_counts = "wheel-weight --lateral 36mm --left-counts -7200 --right-counts -7200";
    let by_turns = "wheel-weight --lateral 36mm --revolutions -8";
    assert_eq!(temp.run(by_counts).ok().stdout, temp.run(by_turns).ok().stdout);
}

#[test]
fn what_a_calibration_would_refuse_is_refused_and_what_it_would_doubt_is_doubted() {
    let temp = TempFolder::new();
    for (arguments, expected) in [
        ("--dx 1mm --dy 10m", "must be from 0.8 to 1.25"),
        ("--dx 2.525cm --dy -150mm", "implausible"),
        ("--lateral 1mm --radius 100m --revolutions 0.001", "geometry.wheel_radius_m = 100"),
        ("--lateral 1mm --revolutions 1000", "too far to determine W_T"),
        ("--lateral 1mm --left-counts 90000 --right-counts 90000", "too far to determine W_T"),
    ] {
        let message = temp.run(&format!("wheel-weight {arguments}")).refused();
        assert!(message.contains(expected), "{arguments}: {message}");
    }
    let rare = "wheel-weight --dx 2.525cm --dy 5mm";
    let warning = "wheels that differ by more than 3 % are rare";
    assert!(temp.run(rare).ok().stderr.contains(warning));
    let value = temp.run(&format!("{rare} --json")).ok().json();
    assert!(value["doubt"].as_str().is_some_and(|doubt| doubt.contains(warning)), "{value}");
    let vague = temp.run("wheel-weight --dx 1mm --dy 0mm").ok();
    assert!(vague.stderr.contains("exceeds the 3 %"), "{vague:#?}");
    let paper = temp.run("wheel-weight --dx 2.525cm --dy 1mm").ok();
    assert_eq!(paper.stderr, "");
}

#[test]
fn no_number_in_an_error_is_a_row_of_zeros() {
    let temp = TempFolder::new();
    for arguments in [
        "config set geometry.wheel_weight -1e300",
        "wheel-weight --lateral -1e300m",
        "wheel-weight --dx 1e-300m --dy 1e300m",
        "wheel-weight --lateral 1mm --counts-per-rev -1e300 --left-counts 1 --right-counts 1",
        "wheel-weight --lateral 1mm --revolutions 1e300",
        "calibrate --distance 1e300m",
        "drive straight 1e300m",
        "drive straight 1m --cruise 1e300m/s",
        "calibrate --side 1e300m --method umbmark",
    ] {
        let message = temp.run(arguments).refused();
        assert!(!message.contains("00000000000000000000"), "{arguments}: {message}");
    }
}
