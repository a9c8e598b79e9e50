//! What is done with the image on the emulated board: its tests, its count of instructions, and a robot
//! that hosts can talk to.

use crate::steps::cargo;
use crate::{Outcome, firmware};

/// The emulator's crate is outside the workspace, and declares a newer compiler than it needs.
const WHERE: [&str; 4] =
    ["--manifest-path", "emulated-board/Cargo.toml", "--ignore-rust-version", "--locked"];

/// Tests the flashed image on the emulated board.
pub fn test() -> Outcome {
    with_image("test", &["--", "--nocapture"])
}

/// Prints what a control tick costs.
pub fn bench() -> Outcome {
    with_image("run", &["--example", "cost"])
}

/// Puts the emulated board behind a TCP port, in real time.
pub fn serve(args: &[&str]) -> Outcome {
    with_image("run", &[&["--bin", "emulate", "--"], args].concat())
}

/// Checks the code of the emulated board's crate.
pub fn clippy() -> Outcome {
    let line = [&["clippy"][..], &WHERE, &["--all-targets", "--", "-D", "warnings"]].concat();
    cargo(&line, &[], "mend what clippy says")
}

fn with_image(what: &str, args: &[&str]) -> Outcome {
    let image = firmware::reference_image()?;
    let image = image.to_str().ok_or("the build folder's name is not UTF-8")?;
    let line = [&[what][..], &WHERE, args].concat();
    cargo(&line, &[("BEELINE_IMAGE", image)], "what failed on the emulated board stands above")
}
