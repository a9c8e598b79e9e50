//! `cargo xtask wheel`: builds the Python wheel, installs it into an environment of its own in the build folder, runs its tests
//! there, and executes its notebook.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::prerequisites;
use crate::repository::{root, target_folder};
use crate::steps::{Outcome, cargo, run};

const FOLDER: &str = "python";
/// What the wheel is built by and tested with. Its only own need, NumPy, comes with the wheel.
const TOOLS: &str = "python/tests/requirements.txt";

/// Builds the wheel and `beeline`, and runs the tests.
pub fn test() -> Outcome {
    prerequisites::meet_for_python()?;
    format()?;
    let environment = environment("wheel", TOOLS)?;
    cargo(&["build", "-p", "host-cli"], &[], "fix the build")?;
    build_into(&environment)?;
    clippy()?;
    pytest(&environment)
}

/// Clippy on the compiled part, which is outside the workspace.
fn clippy() -> Outcome {
    let mut clippy = Command::new("cargo");
    clippy.args(["clippy", "--locked", "--all-targets", "--", "-D", "warnings"]);
    run(compiled(&mut clippy), "fix what clippy says")
}

/// The format of the compiled part.
fn format() -> Outcome {
    let mut format = Command::new("cargo");
    run(compiled(format.args(["fmt", "--check"])), "run `cargo fmt` in python/")
}

/// An environment in the build folder, with what a file of requirements names.
pub fn environment(name: &str, requirements: &str) -> Result<PathBuf, String> {
    let environment = target_folder().join(name);
    let python = environment.join("bin/python");
    // Of an installation that was broken off, there is a Python without packages; pip finds what is missing.
    if !python.exists() {
        let advice = "install Python 3 with its module venv";
        run(Command::new("python3").args(["-m", "venv"]).arg(&environment), advice)?;
    }
    // Few of their modules are ever imported: these are compiled then.
    let install =
        ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-compile", "-r"];
    let mut pip = Command::new(&python);
    pip.args(install).arg(requirements).current_dir(root());
    run(&mut pip, "the packages come from PyPI: is there a network?")?;
    Ok(environment)
}

/// Builds the wheel and installs it, as a development build: its tests want every check for overflow.
fn build_into(environment: &Path) -> Outcome {
    let mut maturin = Command::new(environment.join("bin/maturin"));
    maturin.args(["develop", "--locked", "--quiet"]).env("VIRTUAL_ENV", environment);
    run(compiled(&mut maturin), "fix the build")
}

/// Runs the tests of the package.
fn pytest(environment: &Path) -> Outcome {
    let mut pytest = Command::new(environment.join("bin/python"));
    pytest.args(["-m", "pytest", "--quiet"]).current_dir(root().join(FOLDER));
    pytest.env("BEELINE", target_folder().join("debug/beeline"));
    run(&mut pytest, "each test that failed stands above")
}

/// In the package's folder, and with a build folder of its own: its crates have other features than the workspace's.
fn compiled(command: &mut Command) -> &mut Command {
    command.current_dir(root().join(FOLDER)).env("CARGO_TARGET_DIR", target_folder().join("python"))
}
