//! `cargo xtask peers`: do other programs read our bags, trajectories and parameters, and we their bags? They are Python packages,
//! in an environment of their own in the build folder.

use std::path::Path;
use std::process::Command;

use crate::prerequisites;
use crate::repository::{root, target_folder};
use crate::steps::{Outcome, cargo, run};

const REQUIREMENTS: &str = "import/tests/peers/requirements.txt";
const CHECK: &str = "import/tests/peers/check.py";

/// Installs them where they are missing, builds `beeline`, and runs the check.
pub fn check() -> Outcome {
    prerequisites::meet_for_peers()?;
    let folder = target_folder();
    let environment = folder.join("peers");
    let python = environment.join("bin/python");
    // Of an installation that was broken off, there is a Python without packages; pip finds what is missing.
    if !python.exists() {
        let advice = "install Python 3 with its module venv";
        run(Command::new("python3").args(["-m", "venv"]).arg(&environment), advice)?;
    }
    let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"];
    let mut pip = in_root(&python);
    run(pip.args(install).arg(REQUIREMENTS), "the packages come from PyPI: is there a network?")?;
    cargo(&["build", "-p", "host-cli"], &[], "fix the build")?;
    let beeline = folder.join("debug/beeline");
    run(in_root(&python).arg(CHECK).arg(beeline), "each check that failed stands above")
}

fn in_root(program: &Path) -> Command {
    let mut command = Command::new(program);
    command.current_dir(root());
    command
}
