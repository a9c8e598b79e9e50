//! What is done with the image on the emulated board: its tests, its count of instructions, and a robot
//! that hosts can talk to.

use crate::steps::cargo;
use crate::{Outcome, firmware, target_folder};

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

/// Compiles the tests on the emulated board.
pub fn build_tests() -> Outcome {
    cargo(&line("test", &["--no-run"])?, &[], "fix the build")
}

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
    let line = line("clippy", &["--all-targets", "--", "-D", "warnings"])?;
    cargo(&line, &[], "fix what clippy says")
}

fn with_image(what: &str, args: &[&str]) -> Outcome {
    let image = firmware::reference_image()?;
    let image = image.to_str().ok_or("the build folder's name is not UTF-8")?;
    let variables = [("BEELINE_IMAGE", image)];
    cargo(&line(what, args)?, &variables, "what failed on the emulated board stands above")
}
