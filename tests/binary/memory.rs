//! What a robot remembers: `beeline config`, `calibrate --undo`; the flash is a file.

use serde_json::Value;

use crate::temp_folder::TempFolder;

fn wheel_weight(temp: &TempFolder) -> f64 {
    let value = temp.run("config get geometry.wheel_weight --json --flash flash").ok().json();
    value.as_f64().unwrap()
}

#[test]
fn a_saved_value_survives_and_an_unsaved_one_does_not() {
    let temp = TempFolder::new();
    temp.run("config set geometry.wheel_weight 0.98 --flash flash").ok();
    assert_eq!(wheel_weight(&temp), 1.0);
    let set = temp.run("config set geometry.wheel_weight 0.9919 --save --flash flash").ok();
    assert_eq!(set.stdout, "geometry.wheel_weight: 1.0 -> 0.9919\n");
    assert_eq!(wheel_weight(&temp), 0.9919);
    temp.run("config set name Herbie --save --flash flash").ok();
    let identity = temp.run("identify --flash flash").ok().stdout;
    assert!(identity.contains("Herbie") && !identity.contains("unnamed"), "{identity}");
}

#[test]
fn a_changed_field_is_one_json_value_with_numbers() {
    let temp = TempFolder::new();
    let value =
        temp.run("config set geometry.wheel_weight 0.99 --json --save --flash flash").ok().json();
    let expected: Value = serde_json::json!({
        "changed": {"geometry.wheel_weight": {"before": 1.0, "after": 0.99}},
        "saved": true,
    });
    assert_eq!(value, expected);
}

#[test]
fn an_exported_configuration_can_be_imported_into_another_robot() {
    let temp = TempFolder::new();
    temp.run("config set geometry.track_width_m 0.4 --save --flash one").ok();
    temp.run("config export one.toml --flash one").ok();
    temp.run("config import one.toml --save --flash two").ok();
    let all = |flash: &str| temp.run(&format!("config get --flash {flash}")).ok().stdout;
    assert!(all("two").contains("geometry.track_width_m               0.4 m"), "{}", all("two"));
    assert_eq!(all("one"), all("two"));

    let again = temp.run("config export one.toml --flash one").refused();
    assert!(again.contains("one.toml exists") && again.contains("--force"), "{again}");
    temp.run("config export one.toml --force --flash one").ok();
    let printed = temp.run("config export - --flash one").ok().stdout;
    assert_eq!(printed.trim_end().as_bytes(), temp.read("one.toml").trim_ascii_end());
}

#[test]
fn restore_shows_what_is_saved_or_the_factorys() {
    let temp = TempFolder::new();
    temp.run("config set geometry.wheel_weight 0.99 --save --flash flash").ok();
    let restored = |factory: &str| {
        let value = temp.run(&format!("config restore {factory} --json --flash flash")).ok().json();
        value["geometry"]["wheel_weight"].as_f64().unwrap()
    };
    assert_eq!(restored(""), 0.99);
    assert_eq!(restored("--factory"), 1.0);
    assert_eq!(wheel_weight(&temp), 0.99, "what is saved stays until it is saved over");
}

#[test]
fn a_calibration_is_undone_exactly_and_only_once() {
    let temp = TempFolder::new();
    temp.run("config set geometry.wheel_weight 1.0012345678901234 --save --flash flash").ok();
    temp.run("config export before.toml --flash flash").ok();
    let outcome = temp.run("calibrate --flash flash --json").ok().json();
    assert!((wheel_weight(&temp) - 0.9919).abs() < 1e-3);
    let sure = temp.run("config get odometry --json --flash flash").ok().json();
    assert_eq!(sure["wheel_weight_sd"], outcome["wheel_weight"]["sigma"], "{outcome}");

    temp.run("calibrate --undo --flash flash").ok();
    temp.run("config export after.toml --flash flash").ok();
    assert_eq!(temp.read("before.toml"), temp.read("after.toml"), "to the last digit");
    let message = temp.run("calibrate --undo --flash flash").refused();
    assert!(message.contains("no calibration of this robot to undo"), "{message}");
}

#[test]
fn what_was_changed_since_the_calibration_is_not_undone() {
    let temp = TempFolder::new();
    temp.run("calibrate --flash flash").ok();
    temp.run("config set geometry.wheel_weight 0.97 --save --flash flash").ok();
    let message = temp.run("calibrate --undo --flash flash").refused();
    assert!(message.contains("changed afterwards") && message.contains("0.97"), "{message}");
    assert_eq!(wheel_weight(&temp), 0.97);
}

#[test]
fn without_a_calibration_there_is_nothing_to_undo() {
    let temp = TempFolder::new();
    let message = temp.run("calibrate --undo").refused();
    assert!(message.contains("--flash FILE"), "{message}");
    let message = temp.run("calibrate --undo --flash flash").refused();
    assert!(message.contains("no calibration of this robot to undo"), "{message}");
}

#[test]
fn a_damaged_memory_of_a_calibration_is_named() {
    let temp = TempFolder::new();
    temp.run("calibrate --flash flash").ok();
    let folder = temp.path("state/beeline");
    let file = std::fs::read_dir(&folder).unwrap().next().unwrap().unwrap().path();
    std::fs::write(&file, "before = \"much\"").unwrap();
    let message = temp.run("calibrate --undo --flash flash").refused();
    assert!(message.contains(file.file_name().unwrap().to_str().unwrap()), "{message}");
}

#[test]
fn a_robot_that_drives_straight_already_is_left_alone() {
    let temp = TempFolder::new();
    temp.run("calibrate --flash flash").ok();
    let flash = temp.read("flash");
    // Seen with a ruler, whose sigma is larger than the camera's.
    let outcome = temp.run("calibrate --measure ruler --flash flash").ok();
    assert!(outcome.stdout.contains("Straight already"), "{outcome:#?}");
    assert_eq!(temp.read("flash"), flash);
}

#[test]
fn a_calibration_that_cannot_be_remembered_is_refused_before_the_robot_moves() {
    let temp = TempFolder::new();
    // Where the folder of that name would have to be.
    temp.write("state", "");
    temp.run("config save --flash flash").ok();
    let flash = temp.read("flash");
    let message = temp.run("calibrate --flash flash").refused();
    assert!(message.contains("for --undo") && message.contains("XDG_STATE_HOME"), "{message}");
    assert!(!message.contains("Driving"), "{message}");
    assert_eq!(temp.read("flash"), flash);
    // A robot without a flash needs no memory on the host.
    temp.run("calibrate").ok();
}

#[test]
fn a_name_with_a_quotation_mark_is_itself_for_machines() {
    let temp = TempFolder::new();
    let arguments = ["config", "set", "name", "a\"b", "--json", "--save", "--flash", "flash"];
    let value = temp.run_with(&arguments, "").ok().json();
    assert_eq!(value["changed"]["name"]["after"], "a\"b", "{value}");
}
