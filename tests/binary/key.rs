//! The key of a simulated robot with a flash: set, changed and cleared by the command, and asked for by every other.

use crate::outcome::Outcome;
use crate::temp_folder::TempFolder;

/// A command to the robot whose flash is `robot.flash`.
fn on_robot(temp: &TempFolder, arguments: &str) -> Outcome {
    temp.run(&format!("{arguments} --flash robot.flash"))
}

/// A robot that has the key in `robot.key`.
fn with_key(temp: &TempFolder) {
    temp.run("key new robot.key").ok();
    temp.run("key new other.key").ok();
    on_robot(temp, "key set robot.key").ok();
}

fn refused_without_the_key(temp: &TempFolder) {
    let message = on_robot(temp, "identify").refused();
    assert!(message.contains("--key-file FILE"), "{message}");
    for command in ["identify", "key clear", "drive straight 1rev"] {
        let message = on_robot(temp, &format!("{command} --key-file other.key")).refused();
        assert!(message.contains("has a different key"), "{command}: {message}");
    }
}

#[test]
fn a_key_that_was_set_is_asked_for_until_it_is_cleared() {
    let temp = TempFolder::new();
    with_key(&temp);
    refused_without_the_key(&temp);
    on_robot(&temp, "identify --key-file robot.key").ok();
    on_robot(&temp, "key clear --key-file robot.key").ok();
    on_robot(&temp, "identify").ok();
}

#[test]
fn a_key_is_changed_by_who_has_it() {
    let temp = TempFolder::new();
    with_key(&temp);
    temp.run("key new new.key").ok();
    on_robot(&temp, "key set new.key --key-file robot.key").ok();
    on_robot(&temp, "identify --key-file new.key").ok();
    let message = on_robot(&temp, "identify --key-file robot.key").refused();
    assert!(message.contains("has a different key"), "{message}");
}

#[test]
fn a_key_does_not_cost_the_configuration_that_was_saved() {
    let temp = TempFolder::new();
    on_robot(&temp, "config set geometry.wheel_weight 0.98 --save").ok();
    with_key(&temp);
    on_robot(&temp, "key clear --key-file robot.key").ok();
    let value = on_robot(&temp, "config get geometry.wheel_weight --json").ok().json();
    assert_eq!(value, 0.98);
}
