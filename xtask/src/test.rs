//! `cargo xtask test`: everything that has to hold, in the order in which it fails fastest.
//!
//! The tests run in the dev profile: it optimises, and keeps the checks for integer overflow, which
//! the firmware's fixed-point arithmetic has to pass.

use std::process::Command;

use crate::repository::root;
use crate::steps::{Outcome, Steps, cargo, run as command};
use crate::{
    arrows, boards, circles, dependencies, documents, emulated, firmware, forbidden_words, lengths,
    prerequisites, side_effects, test_binaries, third_party,
};

pub fn run() -> Outcome {
    let mut steps = Steps::new();
    let outcome = all(&mut steps);
    steps.print_summary();
    outcome
}

/// What takes seconds and compiles nothing.
pub fn check() -> Outcome {
    let mut steps = Steps::new();
    let outcome = quick(&mut steps);
    steps.print_summary();
    outcome
}

/// Each of these is run, whatever becomes of the others: all that is to be fixed is seen at once.
fn quick(steps: &mut Steps) -> Outcome {
    type Check = fn() -> Outcome;
    let checks: [(&'static str, Check); 9] = [
        ("format", format),
        ("words", forbidden_words::check),
        ("documents", documents::check),
        ("lengths", lengths::check),
        ("circles", circles::check),
        ("arrows", arrows::check),
        ("side effects", side_effects::check),
        ("third party", third_party::check),
        ("boards", boards::check),
    ];
    let outcomes = checks.map(|(name, check)| steps.run(name, check));
    let failures: Vec<String> = outcomes.into_iter().filter_map(Outcome::err).collect();
    if failures.is_empty() { Ok(()) } else { Err(failures.join("\n\n")) }
}

fn all(steps: &mut Steps) -> Outcome {
    steps.run("needs", prerequisites::meet)?;
    quick(steps)?;
    steps.run("dependencies", dependencies::check)?;
    steps.run("clippy", || {
        cargo(
            &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"],
            &[],
            "fix what clippy says; `cargo clippy --fix` does some of it",
        )
    })?;
    steps.run("doc", || {
        cargo(
            &["doc", "--workspace", "--no-deps"],
            &[("RUSTDOCFLAGS", "-D warnings")],
            "fix the documentation comments",
        )
    })?;
    // What is compiled for them and what they take are two figures: only one is the tests' own.
    let mut binaries = Vec::new();
    steps.run("build tests", || {
        binaries = test_binaries::build()?;
        Ok(())
    })?;
    steps.run("test", || test_binaries::run(&binaries, REAL_TIME))?;
    // They wait more than they compute: more of them run at once than there are cores, and nothing beside them.
    let wait = ["--test-threads", REAL_TIME_THREADS];
    let arguments = [&[REAL_TIME], &wait[..]].concat();
    steps.run("real time", || test_binaries::run_one(&binaries, "binary", &arguments))?;
    steps.run("images", || firmware::run(&[]))?;
    steps.run("images clippy", firmware::clippy)?;
    steps.run("build emulated", emulated::build_tests)?;
    steps.run("emulated", emulated::test)
}

/// The tests of the executable on robots that move in real time.
const REAL_TIME: &str = "real_time::";

/// How many of these run at once.
const REAL_TIME_THREADS: &str = "4";

/// Effects are modules that a macro declares: `cargo fmt` does not see their files.
const EFFECTS: &str = "robot-model/src/effect/catalogue";

fn format() -> Outcome {
    cargo(&["fmt", "--all", "--", "--check"], &[], "run `cargo fmt`")?;
    let entries =
        std::fs::read_dir(root().join(EFFECTS)).map_err(|error| format!("{EFFECTS}: {error}"))?;
    let files = entries.flatten().map(|entry| entry.path());
    let mut rustfmt = Command::new("rustfmt");
    rustfmt.args(["--edition", "2024", "--check"]).args(files).current_dir(root());
    command(&mut rustfmt, &format!("run `rustfmt --edition 2024 {EFFECTS}/*.rs`"))
}
