//! What is done with the image on the emulated board: its tests, its count of instructions, and a robot
//! that hosts can talk to.

use crate::firmware;
use crate::repository::target_folder;
use crate::steps::{LINTING, Outcome, cargo};

/// The emulator's crate is outside the workspace, and declares a newer compiler than it needs. It is
/// built in the workspace's folder all the same: most of what it depends on is there already.
fn line(what: &str, args: &[&str]) -> Result<Vec<String>, String> {
    let folder = target_folder();
    let folder = folder.to_str().ok_or("the build folder's name is not UTF-8")?;
    let place =
        ["--manifest-path", "emulated-board/Cargo.toml", "--ignore-rust-version", "--locked"];
    let line = [&[what][..], &place, &["--target-dir", folder], args].concat();
    Ok(line.into_iter().map(String::from).collect())
}

/// Compiles the tests on the emulated board, and checks the code of its crate: a warning fails the build.
pub fn build_tests() -> Outcome {
    cargo(&line("test", &["--no-run"])?, &LINTING, "fix the build, and what clippy says")
}

/// Tests the flashed image on the emulated board.
pub fn test() -> Outcome {
    with_image("test", &["--", "--nocapture"], &LINTING)
}

/// Prints what a control tick costs.
pub fn bench() -> Outcome {
    with_image("run", &["--example", "cost"], &[])
}

/// Random faults at random instants: `cargo xtask bench faults`.
pub fn bench_faults(args: &[&str]) -> Outcome {
    let line = ["--release", "--example", "faults", "--"];
    with_image("run", &[&line, args].concat(), &[])
}

/// Puts the emulated board behind a TCP port, in real time.
pub fn serve(args: &[&str]) -> Outcome {
    with_image("run", &[&["--bin", "emulate", "--"], args].concat(), &[])
}

fn with_image(what: &str, args: &[&str], variables: &[(&str, &str)]) -> Outcome {
    let image = firmware::reference_image()?;
    let image = image.to_str().ok_or("the build folder's name is not UTF-8")?;
    let variables = [&[("BEELINE_IMAGE", image)], variables].concat();
    cargo(&line(what, args)?, &variables, "what failed on the emulated board stands above")
}
