//! Does every kind of answer of `explain` follow its schema, with the right exit code?

use serde_json::Value;

use crate::example::runs_of;
use crate::schema::violation;
use crate::temp_folder::TempFolder;

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
