//! The workspace's tests, two binaries at a time.
//!
//! Cargo runs one binary after another, and towards the end of each only its longest test still runs: on two cores a
//! sixth of the time is spent waiting for it. Here the next binary has begun by then.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::sync::Mutex;
use std::time::Instant;

use cargo_metadata::Message;

use crate::emulated::{EMULATOR, IMAGE};
use crate::steps::{Outcome, cargo, cargo_command, run as command};

/// So many run at once.
const AT_ONCE: usize = 2;

/// Those that take longest begin first, in this order: what begins last should not be what ends last.
const LONGEST: [&str; 10] = [
    EMULATED,
    "binary",
    "robot_model",
    "scenarios",
    "tuning",
    "closed_loop",
    "blind",
    "corpora",
    "optiodom",
    "campaign",
];

/// The tests of the flashed image on the emulated board. What they print is worth reading when they pass. They run one
/// after another: the emulator changes what memory it may execute all the time, and each change interrupts every core
/// that another thread of the process runs on.
const EMULATED: &str = "board";
const EMULATED_ARGUMENTS: [&str; 2] = ["--nocapture", "--test-threads=1"];

/// The examples that tests run (`tests/binary/libraries.rs`). The others, most of them benches, are compiled by clippy
/// alone: nothing here needs their code.
const EXAMPLES: [&str; 3] = ["drive", "read_campaign", "explain"];

/// A test binary.
pub struct TestBinary {
    name: String,
    executable: PathBuf,
    /// The folder of its package, in which its tests run.
    folder: PathBuf,
}

/// Builds all test binaries of the workspace.
pub fn build() -> Result<Vec<TestBinary>, String> {
    let line = ["test", "--workspace", "--no-run", "--message-format=json-render-diagnostics"];
    let targets = ["--lib", "--bins", "--tests"];
    let mut command = cargo_command(&[&line[..], &targets, &EMULATOR].concat());
    command.stdout(Stdio::piped()).stderr(Stdio::inherit());
    println!("    cargo test --workspace --no-run");
    let output = command.output().map_err(|error| format!("cannot run cargo: {error}"))?;
    if !output.status.success() {
        return Err("`cargo test --workspace --no-run` failed\n       fix the build".into());
    }
    // Asked for by name, `cargo test` would build their tests instead.
    let examples = EXAMPLES.iter().flat_map(|name| ["--example", name]);
    let line: Vec<&str> =
        ["build", "--workspace"].into_iter().chain(examples).chain(EMULATOR).collect();
    cargo(&line, &[], "fix the build of the examples")?;
    let messages = Message::parse_stream(output.stdout.as_slice());
    let mut binaries: Vec<TestBinary> = messages
        .filter_map(|message| match message {
            Ok(Message::CompilerArtifact(artifact)) if artifact.profile.test => {
                let folder = artifact.manifest_path.parent()?.into();
                let executable = artifact.executable?.into();
                Some(TestBinary { name: artifact.target.name, executable, folder })
            }
            _ => None,
        })
        .collect();
    let rank = |name: &str| LONGEST.iter().position(|long| *long == name).unwrap_or(LONGEST.len());
    binaries.sort_by_key(|binary| rank(&binary.name));
    Ok(binaries)
}

/// Runs them all, whatever becomes of each, without the tests whose names contain `skip`; then the examples in the
/// documentation. `image` is the path of the reference board's image.
pub fn run(binaries: &[TestBinary], skip: &str, image: &str) -> Outcome {
    let waiting: Mutex<VecDeque<&TestBinary>> = Mutex::new(binaries.iter().collect());
    let failed = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..AT_ONCE {
            scope.spawn(|| {
                while let Some(binary) = next(&waiting) {
                    let begun = Instant::now();
                    let mut arguments = vec!["--skip", skip];
                    if binary.name == EMULATED {
                        arguments.extend(EMULATED_ARGUMENTS);
                    }
                    let outcome = binary.run(&arguments, &[(IMAGE, image)]);
                    let seconds = begun.elapsed().as_secs_f64();
                    let mut failed = failed.lock().expect("no holder has panicked");
                    if !print(binary, &outcome, seconds) {
                        failed.push(binary.executable.display().to_string());
                    }
                }
            });
        }
    });
    let failed = failed.into_inner().expect("no holder has panicked");
    let documentation = [&["test", "--workspace", "--doc"], &EMULATOR[..]].concat();
    let documentation = command(&mut cargo_command(&documentation), ADVICE);
    match failed.is_empty() {
        true => documentation,
        false => Err(format!("{}\n       {ADVICE}", failed.join("\n"))),
    }
}

/// Runs the binary of this name with these arguments.
pub fn run_one(binaries: &[TestBinary], name: &str, arguments: &[&str]) -> Outcome {
    let binary = binaries.iter().find(|binary| binary.name == name);
    let binary = binary.ok_or_else(|| format!("there is no test binary `{name}`"))?;
    let begun = Instant::now();
    let outcome = binary.run(arguments, &[]);
    match print(binary, &outcome, begun.elapsed().as_secs_f64()) {
        true => Ok(()),
        false => Err(format!("{}\n       {ADVICE}", binary.executable.display())),
    }
}

const ADVICE: &str = "the failed tests and their messages stand above, under `failures:`";

fn next<'a>(waiting: &Mutex<VecDeque<&'a TestBinary>>) -> Option<&'a TestBinary> {
    waiting.lock().expect("no holder has panicked").pop_front()
}

/// Prints what a binary said, all at once; whether its tests passed.
fn print(binary: &TestBinary, outcome: &std::io::Result<Output>, seconds: f64) -> bool {
    println!("\n    {} ({seconds:.1} s)", binary.executable.display());
    match outcome {
        Ok(output) => {
            print!("{}", String::from_utf8_lossy(&output.stdout));
            eprint!("{}", String::from_utf8_lossy(&output.stderr));
            output.status.success()
        }
        Err(error) => {
            println!("    it cannot be run: {error}");
            false
        }
    }
}

impl TestBinary {
    fn run(&self, arguments: &[&str], variables: &[(&str, &str)]) -> std::io::Result<Output> {
        Command::new(&self.executable)
            .args(arguments)
            .current_dir(&self.folder)
            // As cargo sets it; this chore has its own.
            .env("CARGO_MANIFEST_DIR", &self.folder)
            .envs(variables.iter().copied())
            .stdin(Stdio::null())
            .output()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repository::root;

    fn binary(name: &str, executable: &str) -> TestBinary {
        TestBinary { name: name.into(), executable: executable.into(), folder: root().into() }
    }

    #[test]
    fn a_binary_that_fails_or_cannot_be_run_is_told_and_one_that_passes_is_not() {
        let pass = binary("pass", "true");
        let outcome = pass.run(&[], &[]);
        assert!(print(&pass, &outcome, 0.0));
        for broken in ["false", "/no/such/program"] {
            let broken = binary("broken", broken);
            let outcome = broken.run(&[], &[]);
            assert!(!print(&broken, &outcome, 0.0));
        }
    }
}
