//! What a robot remembers: `beeline config`, `calibrate --undo`; the flash is a file.

use serde_json::Value;

use crate::desk::Desk;

fn wheel_weight(desk: &Desk) -> f64 {
    let value = desk.run("config get geometry.wheel_weight --json --flash flash").ok().json();
    value.as_f64().unwrap()
}

#[test]
fn a_saved_value_survives_and_an_unsaved_one_does_not() {
    let desk = Desk::new();
    desk.run("config set geometry.wheel_weight 0.98 --flash flash").ok();
    assert_eq!(wheel_weight(&desk), 1.0);
    let set = desk.run("config set geometry.wheel_weight 0.9919 --save --flash flash").ok();
    assert_eq!(set.stdout, "geometry.wheel_weight: 1.0 -> 0.9919\n");
    assert_eq!(wheel_weight(&desk), 0.9919);
    desk.run("config set name Herbie --save --flash flash").ok();
    let identity = desk.run("identify --flash flash").ok().stdout;
    assert!(identity.contains("Herbie") && !identity.contains("unnamed"), "{identity}");
}

#[test]
fn a_changed_field_is_one_json_value_with_numbers() {
    let desk = Desk::new();
    let value =
        desk.run("config set geometry.wheel_weight 0.99 --json --save --flash flash").ok().json();
    let expected: Value = serde_json::json!({
        "changed": {"geometry.wheel_weight": {"before": 1.0, "after": 0.99}},
        "saved": true,
    });
    assert_eq!(value, expected);
}

#[test]
fn an_exported_configuration_can_be_imported_into_another_robot() {
    let desk = Desk::new();
    desk.run("config set geometry.track_width_m 0.4 --save --flash one").ok();
    desk.run("config export one.toml --flash one").ok();
    desk.run("config import one.toml --save --flash two").ok();
    let all = |flash: &str| desk.run(&format!("config get --flash {flash}")).ok().stdout;
    assert!(all("two").contains("geometry.track_width_m               0.4 m"), "{}", all("two"));
    assert_eq!(all("one"), all("two"));

    let again = desk.run("config export one.toml --flash one").refused();
    assert!(again.contains("one.toml exists") && again.contains("--force"), "{again}");
    desk.run("config export one.toml --force --flash one").ok();
    let printed = desk.run("config export - --flash one").ok().stdout;
    assert_eq!(printed.trim_end().as_bytes(), desk.read("one.toml").trim_ascii_end());
}

#[test]
fn restore_shows_what_is_saved_or_the_factorys() {
    let desk = Desk::new();
    desk.run("config set geometry.wheel_weight 0.99 --save --flash flash").ok();
    let restored = |factory: &str| {
        let value = desk.run(&format!("config restore {factory} --json --flash flash")).ok().json();
        value["geometry"]["wheel_weight"].as_f64().unwrap()
    };
    assert_eq!(restored(""), 0.99);
    assert_eq!(restored("--factory"), 1.0);
    assert_eq!(wheel_weight(&desk), 0.99, "what is saved stays until it is saved over");
}

#[test]
fn a_calibration_is_undone_exactly_and_only_once() {
    let desk = Desk::new();
    desk.run("config set geometry.wheel_weight 1.0012345678901234 --save --flash flash").ok();
    desk.run("config export before.toml --flash flash").ok();
    desk.run("calibrate --flash flash").ok();
    assert!((wheel_weight(&desk) - 0.9919).abs() < 1e-3);

    desk.run("calibrate --undo --flash flash").ok();
    desk.run("config export after.toml --flash flash").ok();
    assert_eq!(desk.read("before.toml"), desk.read("after.toml"), "to the last digit");
    let message = desk.run("calibrate --undo --flash flash").refused();
    assert!(message.contains("no calibration of this robot to undo"), "{message}");
}

#[test]
fn what_was_changed_since_the_calibration_is_not_undone() {
    let desk = Desk::new();
    desk.run("calibrate --flash flash").ok();
    desk.run("config set geometry.wheel_weight 0.97 --save --flash flash").ok();
    let message = desk.run("calibrate --undo --flash flash").refused();
    assert!(message.contains("changed afterwards") && message.contains("0.97"), "{message}");
    assert_eq!(wheel_weight(&desk), 0.97);
}

#[test]
fn without_a_calibration_there_is_nothing_to_undo() {
    let desk = Desk::new();
    let message = desk.run("calibrate --undo").refused();
    assert!(message.contains("--flash FILE"), "{message}");
    let message = desk.run("calibrate --undo --flash flash").refused();
    assert!(message.contains("no calibration of this robot to undo"), "{message}");
}

#[test]
fn a_damaged_memory_of_a_calibration_is_named() {
    let desk = Desk::new();
    desk.run("calibrate --flash flash").ok();
    let folder = desk.path("state/beeline");
    let file = std::fs::read_dir(&folder).unwrap().next().unwrap().unwrap().path();
    std::fs::write(&file, "before = \"much\"").unwrap();
    let message = desk.run("calibrate --undo --flash flash").refused();
    assert!(message.contains(file.file_name().unwrap().to_str().unwrap()), "{message}");
}

#[test]
fn a_robot_that_drives_straight_already_is_left_alone() {
    let desk = Desk::new();
    desk.run("calibrate --flash flash").ok();
    let flash = desk.read("flash");
    // Seen with a ruler, whose sigma is larger than the camera's.
    let outcome = desk.run("calibrate --measure ruler --flash flash").ok();
    assert!(outcome.stdout.contains("Straight already"), "{outcome:#?}");
    assert_eq!(desk.read("flash"), flash);
}

#[test]
fn a_calibration_that_cannot_be_remembered_is_refused_before_the_robot_moves() {
    let desk = Desk::new();
    // Where the folder of that name would have to be.
    desk.write("state", "");
    desk.run("config save --flash flash").ok();
    let flash = desk.read("flash");
    let message = desk.run("calibrate --flash flash").refused();
    assert!(message.contains("for --undo") && message.contains("XDG_STATE_HOME"), "{message}");
    assert!(!message.contains("Driving"), "{message}");
    assert_eq!(desk.read("flash"), flash);
    // A robot without a flash needs no memory on the host.
    desk.run("calibrate").ok();
}

#[test]
fn a_name_with_a_quotation_mark_is_itself_for_machines() {
    let desk = Desk::new();
    let arguments = ["config", "set", "name", "a\"b", "--json", "--save", "--flash", "flash"];
    let value = desk.run_with(&arguments, "").ok().json();
    assert_eq!(value["changed"]["name"]["after"], "a\"b", "{value}");
}
