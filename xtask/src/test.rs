//! `cargo xtask test`: everything that has to hold, in the order in which it fails fastest.
//!
//! The tests run in the dev profile: it optimises, and keeps the checks for integer overflow, which
//! the firmware's fixed-point arithmetic has to pass.

use std::process::Command;
use std::time::Instant;

use crate::emulated::EMULATOR;
use crate::repository::root;
use crate::steps::{Outcome, Steps, cargo, run as command};
use crate::test_binaries::TestBinary;
use crate::{
    arrows, boards, browser, circles, dependencies, documents, emulated, firmware, forbidden_words,
    lengths, peers, prerequisites, side_effects, test_binaries, third_party,
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
    let checks: [(&'static str, Check); 10] = [
        ("format", format),
        ("words", forbidden_words::check),
        ("documents", documents::check),
        ("lengths", lengths::check),
        ("circles", circles::check),
        ("arrows", arrows::check),
        ("side effects", side_effects::check),
        ("third party", third_party::check),
        ("boards", boards::check),
        ("locks", dependencies::locks),
    ];
    let outcomes = checks.map(|(name, check)| steps.run(name, check));
    let failures: Vec<String> = outcomes.into_iter().filter_map(Outcome::err).collect();
    if failures.is_empty() { Ok(()) } else { Err(failures.join("\n\n")) }
}

fn all(steps: &mut Steps) -> Outcome {
    steps.run("needs", prerequisites::meet)?;
    quick(steps)?;
    steps.run("dependencies", dependencies::check)?;
    let with_emulator = |line: &[&'static str]| [line, &EMULATOR].concat();
    steps.run("clippy", || {
        let line = with_emulator(&["clippy", "--workspace", "--all-targets"]);
        cargo(
            &[&line[..], &["--", "-D", "warnings"]].concat(),
            &[],
            "fix what clippy says; `cargo clippy --fix` does some of it",
        )
    })?;
    steps.run("doc", || {
        cargo(
            &with_emulator(&["doc", "--workspace", "--no-deps"]),
            &[("RUSTDOCFLAGS", "-D warnings")],
            "fix the documentation comments",
        )
    })?;
    // What is compiled for them and what they take are two figures: only one is the tests' own.
    let binaries = build(steps)?;
    steps.run("images clippy", firmware::clippy)?;
    let image = emulated::image()?;
    beside(
        steps,
        ("test", || test_binaries::run(&binaries, REAL_TIME, &image)),
        ("browser and peers", || browser::test().and_then(|()| peers::check_built())),
    )?;
    // They wait more than they compute: more of them run at once than there are cores, and nothing beside them.
    let wait = ["--test-threads", REAL_TIME_THREADS];
    let arguments = [&[REAL_TIME], &wait[..]].concat();
    steps.run("real time", || test_binaries::run_one(&binaries, "binary", &arguments))?;
    steps.run("robot's page", || browser::real_time(&image))
}

/// Builds the tests, and the images beside them: of an image the last and longest part, its optimisation as a whole,
/// keeps one core busy. The two have build folders of their own.
fn build(steps: &mut Steps) -> Result<Vec<TestBinary>, String> {
    let mut binaries = Vec::new();
    let tests = || {
        binaries = test_binaries::build()?;
        Ok(())
    };
    beside(steps, ("build tests", tests), ("images", || firmware::run(&[])))?;
    Ok(binaries)
}

/// Runs a step, and another one beside it. Both end, whatever becomes of either.
fn beside(
    steps: &mut Steps,
    (name, step): (&'static str, impl FnOnce() -> Outcome),
    (other_name, other): (&'static str, impl FnOnce() -> Outcome + Send),
) -> Outcome {
    std::thread::scope(|scope| {
        let other = scope.spawn(|| {
            let begun = Instant::now();
            (other(), begun.elapsed())
        });
        let outcome = steps.run(name, step);
        let (other, took) = other.join().expect("a chore does not panic");
        let other = steps.took(other_name, took, other);
        outcome.and(other)
    })
}

/// The tests of the executable on robots that move in real time.
const REAL_TIME: &str = "real_time::";

/// How many of these run at once.
const REAL_TIME_THREADS: &str = "4";

/// Effects are modules that a macro declares: `cargo fmt` does not see their files.
const EFFECTS: [&str; 2] =
    ["robot-model/src/effect/catalogue", "robot-model/src/drivetrain/effect"];

fn format() -> Outcome {
    cargo(&["fmt", "--all", "--", "--check"], &[], "run `cargo fmt`")?;
    let mut files = Vec::new();
    for folder in EFFECTS {
        let entries =
            std::fs::read_dir(root().join(folder)).map_err(|error| format!("{folder}: {error}"))?;
        let paths = entries.flatten().map(|entry| entry.path());
        files.extend(paths.filter(|path| path.extension().is_some_and(|end| end == "rs")));
    }
    let mut rustfmt = Command::new("rustfmt");
    rustfmt.args(["--edition", "2024", "--check"]).args(files).current_dir(root());
    let folders = EFFECTS.map(|folder| format!("{folder}/*.rs")).join(" ");
    command(&mut rustfmt, &format!("run `rustfmt --edition 2024 {folders}`"))
}
