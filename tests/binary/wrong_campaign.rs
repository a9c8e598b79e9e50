//! Campaigns with something wrong: the data sheet, a clock, a column. Is it named before anything else is explained?

use serde_json::Value;

use crate::example::{change_column, runs_of, shift_poses};
use crate::temp_folder::TempFolder;

/// All runs of a simulated robot whose wheels have a radius of 36 mm.
fn mystery() -> TempFolder {
    let temp = TempFolder::new();
    runs_of(&temp, "mystery-robot", &[""], "robot");
    temp
}

#[test]
fn a_radius_that_is_5_percent_off_is_the_first_thing_said_and_nothing_is_written_before_it_is_set()
{
    let temp = mystery();
    let toml = String::from_utf8(temp.read("robot/robot.toml")).unwrap();
    assert!(toml.contains("wheel_radius_m = 0.036\n"), "{toml}");
    temp.write("robot/robot.toml", &toml.replace("= 0.036\n", "= 0.0342\n"));
    let said = temp.run("explain robot").ok().stdout;
    let number = said.strip_prefix("Set wheel_radius_m = ").unwrap_or_else(|| panic!("{said}"));
    let radius_m: f64 = number.split_whitespace().next().unwrap().parse().unwrap();
    // Four digits are printed, and the radius grows with the speed by up to 0.7 %.
    assert!((radius_m / 0.036 - 1.0).abs() < 0.01, "{radius_m}");
    assert!(number.contains("(now 0.0342) in robot.toml."), "{said}");

    temp.run("config save --flash flash").ok();
    let before = temp.read("flash");
    let message = temp.run("apply robot --yes --flash flash").refused();
    assert!(message.contains("nothing was written: robot.toml is far off"), "{message}");
    assert!(message.contains("Set wheel_radius_m = "), "{message}");
    assert_eq!(temp.read("flash"), before);
}

#[test]
fn poses_that_are_late_by_a_constant_are_named_to_ten_milliseconds_in_a_recorded_campaign() {
    for late_s in [0.5, 3.72] {
        let temp = mystery();
        shift_poses(&temp, "robot", late_s);
        let answer = temp.run("explain robot --json").ok().json();
        let clocks = answer["clocks"].as_array().unwrap();
        assert_eq!(clocks.len(), 21, "{late_s}: {answer:#}");
        let mut offsets: Vec<f64> =
            clocks.iter().map(|clock| clock["offset_s"].as_f64().unwrap()).collect();
        offsets.sort_by(f64::total_cmp);
        assert!((offsets[10] - late_s).abs() < 0.01, "{late_s}: {offsets:?}");
        // With the clocks brought together, the effect that was hidden in this robot is found.
        assert_eq!(answer["steps"][0]["effect"], "speed_growth", "{late_s}: {answer:#}");
        if late_s > 1.0 {
            let said = temp.run("explain robot").ok().stdout;
            assert!(said.contains("the poses of all 21 runs are 3.72 s late"), "{said}");
        }
    }
}

#[test]
fn headings_in_degrees_are_named_as_such_with_their_column() {
    let temp = mystery();
    change_column(&temp, "robot", "heading_rad", |rad| format!("{:.4}", rad.to_degrees()));
    let message = temp.run("explain robot").refused();
    for words in ["line 1, column 9", "heading_rad looks like degrees", "heading_rad * pi / 180"] {
        assert!(message.contains(words), "{words}: {message}");
    }
}

#[test]
fn a_counter_of_16_bits_that_went_round_is_named_as_such_with_its_row() {
    let temp = mystery();
    // It begins 5536 counts below its end.
    let round = |counts: f64| format!("{}", (counts + 60_000.0).rem_euclid(65_536.0));
    change_column(&temp, "robot", "left_counts", round);
    let message = temp.run("explain robot").refused();
    for words in [
        "column 2: ",
        "left_counts goes from 65",
        "in one step: its 16-bit counter wrapped around",
        "add 65536 from this row on",
    ] {
        assert!(message.contains(words), "{words}: {message}");
    }
}

#[test]
fn model_add_and_compare_have_one_error_for_an_effect_of_ones_own() {
    let temp = mystery();
    let equation = "ds_left/ds = c * max(0, v_left - v0) / v0";
    let add = ["model", "add", "--custom", equation, "--unit", "v0=m/s", "robot", "--json"];
    let added = temp.run_with(&add, "").ok().json();
    let compared = temp.run("compare robot --json").ok().json();
    let number = |value: &Value, pointer: &str| value.pointer(pointer).unwrap().as_f64().unwrap();
    let (one, other) = (
        number(&added, "/after/train/position_rms_m"),
        number(&compared, "/comparison/position_m/rms"),
    );
    // Alike as printed, in tenths of a millimetre, but for rounding.
    assert!((one - other).abs() < 1e-4, "{one} {other}");
}

#[test]
fn apply_of_a_model_with_only_an_effect_of_ones_own_says_what_the_firmware_cannot_do() {
    let temp = mystery();
    let add = ["model", "add", "--custom", "dtheta = k * v^2 * omega", "--name", "mine", "robot"];
    temp.run_with(&add, "").ok();
    temp.run("config save --flash flash").ok();
    let before = temp.read("flash");
    let outcome = temp.run("apply robot --yes --flash flash").ok();
    let said = outcome.stdout + &outcome.stderr;
    for words in [
        "mine                   not compensated, as the firmware has no term for it",
        "nothing to write: the firmware has no term for any of these effects",
        "`beeline model add wheel_radius_ratio wheel_radius_scale track_width`",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert!(!said.contains("agree with the campaign"), "{said}");
    assert_eq!(temp.read("flash"), before);
}
