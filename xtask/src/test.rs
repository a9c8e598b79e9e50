//! `cargo xtask test`: everything that has to hold, in the order in which it fails fastest.
//!
//! The tests run in the dev profile: it optimises, and keeps the checks for integer overflow, which
//! the firmware's fixed-point arithmetic has to pass.

use crate::steps::{Steps, cargo};
use crate::{Outcome, documents, emulated, firmware, needs, words};

pub fn run() -> Outcome {
    let mut steps = Steps::default();
    let outcome = all(&mut steps);
    steps.print_summary();
    outcome
}

fn all(steps: &mut Steps) -> Outcome {
    steps.run("needs", needs::meet)?;
    steps.run("format", || cargo(&["fmt", "--all", "--", "--check"], &[], "run `cargo fmt`"))?;
    steps.run("words", words::check)?;
    steps.run("documents", documents::check)?;
    steps.run("clippy", || {
        cargo(
            &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"],
            &[],
            "mend what clippy says; `cargo clippy --fix` does some of it",
        )
    })?;
    // The end-to-end tests start the binary as a user would.
    steps.run("build", || cargo(&["build", "--workspace", "--bins"], &[], "mend the build"))?;
    steps.run("test", || {
        cargo(
            &["test", "--workspace", "--no-fail-fast"],
            &[],
            "the failed tests and their messages stand above, under `failures:`",
        )
    })?;
    steps.run("images", || firmware::run(&[]))?;
    steps.run("images clippy", firmware::clippy)?;
    steps.run("emulated clippy", emulated::clippy)?;
    steps.run("emulated", emulated::test)?;
    steps.run("doc", || {
        cargo(
            &["doc", "--workspace", "--no-deps"],
            &[("RUSTDOCFLAGS", "-D warnings")],
            "mend the documentation comments",
        )
    })
}
