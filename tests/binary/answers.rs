//! Does every kind of answer of `explain` follow its schema, with the right exit code?

use std::path::Path;

use serde_json::Value;

use crate::schema::violation;
use crate::temp_folder::TempFolder;

/// Copies those runs of an example whose names contain one of these parts.
fn runs_of(temp: &TempFolder, example: &str, parts: &[&str], to: &str) {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(example);
    std::fs::create_dir_all(temp.path(&format!("{to}/runs"))).unwrap();
    let text = std::fs::read_to_string(from.join("robot.toml")).unwrap();
    let robot = text.split("[[run]]").next().unwrap();
    temp.write(&format!("{to}/robot.toml"), robot);
    for entry in std::fs::read_dir(from.join("runs")).unwrap() {
        let file = entry.unwrap().path();
        let name = file.file_name().unwrap().to_str().unwrap().to_owned();
        if parts.iter().any(|part| name.contains(part)) {
            std::fs::copy(&file, temp.path(&format!("{to}/runs/{name}"))).unwrap();
        }
    }
}

/// The answer to a campaign. It must follow the schema, and its exit code must say whether something is missing.
fn explained(temp: &TempFolder, campaign: &str) -> Value {
    let outcome = temp.run(&format!("explain {campaign} --format json --exit-code"));
    let answer = outcome.json();
    assert_eq!(violation(&answer), None, "{campaign}");
    let missing = steps(&answer) > 0 || answer["unexplained"]["structure"] == true;
    assert_eq!(outcome.code, Some(i32::from(missing)), "{campaign}");
    answer
}

fn steps(answer: &Value) -> usize {
    answer["steps"].as_array().unwrap().len()
}

#[test]
fn nothing_missing() {
    let temp = TempFolder::new();
    runs_of(&temp, "mystery-robot", &["rest"], "robot");
    let answer = explained(&temp, "robot");
    assert_eq!(steps(&answer), 0, "{answer:#}");
    assert_eq!(answer["unexplained"]["structure"], false, "{answer:#}");
    assert_eq!(answer["unexplained"]["depends_on"], serde_json::json!([]));
    assert!(temp.run("explain robot").ok().stdout.starts_with("Nothing is missing"));
}

#[test]
fn one_effect_and_no_further_run() {
    let temp = TempFolder::new();
    runs_of(&temp, "mystery-robot", &[""], "robot");
    let answer = explained(&temp, "robot");
    assert_eq!(steps(&answer), 1, "{answer:#}");
    assert_eq!(answer["next_run"], Value::Null, "{answer:#}");
}

#[test]
fn a_class_and_the_run_that_tells_it_apart() {
    let temp = TempFolder::new();
    runs_of(&temp, "mystery-robot", &["spin_fast"], "robot");
    let answer = explained(&temp, "robot");
    let class = answer["steps"][0]["class"].as_array().unwrap();
    assert!(class.len() > 1, "{answer:#}");
    assert!(class.contains(&answer["steps"][0]["effect"]), "the chosen one is included");
    assert!(answer["next_run"]["kind"].is_string(), "{answer:#}");
}

#[test]
fn structure_that_nothing_explains() {
    let temp = TempFolder::new();
    runs_of(&temp, "optiodom", &["circular", "ivanjko"], "robot");
    let answer = explained(&temp, "robot");
    assert_eq!(answer["unexplained"]["structure"], true, "{answer:#}");
    assert!(!answer["unexplained"]["depends_on"].as_array().unwrap().is_empty(), "{answer:#}");
}
