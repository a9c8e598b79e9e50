//! The tests of the page of `beeline serve` in a real browser (`tests/browser/`).

use std::process::Command;

use crate::repository::{root, target_folder};
use crate::steps::{Outcome, run};

const FOLDER: &str = "tests/browser";

/// Runs them on the command that the tests were built with.
pub fn test() -> Outcome {
    let folder = root().join(FOLDER);
    let npm = ["ci", "--no-audit", "--no-fund", "--loglevel=error"];
    run(
        Command::new("npm").args(npm).current_dir(&folder),
        "npm could not install what tests/browser/package-lock.json names: is there a network?",
    )?;
    let beeline = target_folder().join("debug").join("beeline");
    let mut node = Command::new("node");
    node.args(["--test", "--test-reporter=spec"]).current_dir(&folder).env("BEELINE", beeline);
    run(
        &mut node,
        "what failed in the browser stands above; pictures of the page are in target/browser",
    )
}
