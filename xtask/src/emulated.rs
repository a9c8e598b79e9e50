//! What is done with the image on the emulated board: its count of instructions, and a robot that hosts can talk to.
//! Its tests run with those of the workspace (`test_binaries`).

use crate::firmware;
use crate::steps::{Outcome, cargo};

/// What cargo needs to compile the emulator: a feature, because it declares a newer compiler than it needs.
pub const EMULATOR: [&str; 3] = ["--features", "emulated-board/emulator", "--ignore-rust-version"];

/// Prints what a control tick costs.
pub fn bench() -> Outcome {
    with_image(&["--example", "cost"])
}

/// Random faults at random instants: `cargo xtask bench faults`.
pub fn bench_faults(args: &[&str]) -> Outcome {
    let line = ["--release", "--example", "faults", "--"];
    with_image(&[&line, args].concat())
}

/// Hosts that die while the robot drives: `cargo xtask bench dead-hosts`.
pub fn bench_dead_hosts(args: &[&str]) -> Outcome {
    let line = ["--release", "--example", "dead_hosts", "--"];
    with_image(&[&line, args].concat())
}

/// Puts the emulated board behind a TCP port, in real time.
pub fn serve(args: &[&str]) -> Outcome {
    with_image(&[&["--bin", "emulate", "--"], args].concat())
}

/// The variable with the image's path.
pub const IMAGE: &str = "BEELINE_IMAGE";

/// The reference board's image as the value of that variable, built if it has changed.
pub fn image() -> Result<String, String> {
    let image = firmware::reference_image()?;
    let image = image.to_str().ok_or("the build folder's name is not UTF-8")?;
    Ok(image.to_owned())
}

fn with_image(args: &[&str]) -> Outcome {
    let line = [&["run", "--package", "emulated-board", "--locked"], &EMULATOR[..], args].concat();
    cargo(&line, &[(IMAGE, &image()?)], "what failed on the emulated board stands above")
}
