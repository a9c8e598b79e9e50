//! The tests of the page of `beeline serve` in a real browser (`tests/browser/`).

use std::process::Command;

use crate::emulated::IMAGE;
use crate::repository::{root, target_folder};
use crate::steps::{Outcome, cargo, run};

const FOLDER: &str = "tests/browser";

/// The pages that compute, on the command that the tests were built with.
pub fn test() -> Outcome {
    fetch()?;
    node("model_page.test.mjs")
}

/// How fast the pages are, by a release build.
pub fn bench() -> Outcome {
    fetch()?;
    cargo(&["build", "--release", "-p", "host-cli"], &[], "the command does not build")?;
    let mut node = Command::new("node");
    let beeline = target_folder().join("release").join("beeline");
    node.arg("bench.mjs").current_dir(root().join(FOLDER)).env("BEELINE", beeline);
    run(&mut node, "what went wrong stands above")
}

/// What drives the browser.
fn fetch() -> Outcome {
    let npm = ["ci", "--no-audit", "--no-fund", "--loglevel=error"];
    run(
        Command::new("npm").args(npm).current_dir(root().join(FOLDER)),
        "npm could not install what tests/browser/package-lock.json names: is there a network?",
    )
}

/// The page of robots that move in real time, one of them this image on the emulated board, once [`test()`] has fetched what
/// drives the browser.
pub fn real_time(image: &str) -> Outcome {
    let emulator = target_folder().join("debug").join("emulate");
    let with = |node: &mut Command| {
        node.env("BEELINE_EMULATOR", &emulator).env(IMAGE, image);
    };
    node_with("robot_page.test.mjs", with)?;
    node_with("procedures.test.mjs", with)
}

fn node(tests: &str) -> Outcome {
    node_with(tests, |_| ())
}

fn node_with(tests: &str, with: impl Fn(&mut Command)) -> Outcome {
    let beeline = target_folder().join("debug").join("beeline");
    let mut node = Command::new("node");
    node.args(["--test", "--test-reporter=spec", tests]);
    node.current_dir(root().join(FOLDER)).env("BEELINE", beeline);
    with(&mut node);
    run(
        &mut node,
        "what failed in the browser stands above; pictures of the page are in target/browser",
    )
}
