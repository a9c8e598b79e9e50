//! `cargo xtask peers`: do other programs read our bags, trajectories and parameters, and we their bags? They are Python packages,
//! in an environment of their own in the build folder. A part of `cargo xtask test`.

use std::process::Command;

use crate::prerequisites;
use crate::repository::{root, target_folder};
use crate::steps::{Outcome, cargo, run};
use crate::wheel;

const REQUIREMENTS: &str = "import/tests/peers/requirements.txt";
const CHECK: &str = "import/tests/peers/check.py";

/// Installs them where they are missing, builds `beeline`, and runs the checks.
pub fn check() -> Outcome {
    cargo(&["build", "-p", "host-cli"], &[], "fix the build")?;
    check_built()
}

/// The same, once `beeline` is built.
pub fn check_built() -> Outcome {
    prerequisites::meet_for_python()?;
    let environment = wheel::environment("peers", REQUIREMENTS)?;
    let mut check = Command::new(environment.join("bin/python"));
    check.arg(CHECK).arg(target_folder().join("debug/beeline")).current_dir(root());
    run(&mut check, "each check that failed stands above")
}
