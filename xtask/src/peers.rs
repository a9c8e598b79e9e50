//! `cargo xtask peers`: do other programs read our bags, trajectories and parameters, and we their bags? They are Python packages,
//! in an environment of their own in the build folder. The notebook of our own package is executed there too, and its compiled part checked by clippy.

use std::process::Command;

use crate::prerequisites;
use crate::repository::{root, target_folder};
use crate::steps::{Outcome, cargo, run};
use crate::wheel;

const REQUIREMENTS: &str = "import/tests/peers/requirements.txt";
const CHECK: &str = "import/tests/peers/check.py";

/// Installs them where they are missing, builds `beeline` and the wheel, and runs the checks.
pub fn check() -> Outcome {
    prerequisites::meet_for_python()?;
    let environment = wheel::environment("peers", REQUIREMENTS)?;
    cargo(&["build", "-p", "host-cli"], &[], "fix the build")?;
    wheel::build_into(&environment)?;
    let mut check = Command::new(environment.join("bin/python"));
    check.arg(CHECK).arg(target_folder().join("debug/beeline")).current_dir(root());
    run(&mut check, "each check that failed stands above")?;
    wheel::clippy()?;
    wheel::pytest(&environment, &["tests/test_notebook.py"])
}
