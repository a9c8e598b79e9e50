//! Runs named steps, times them, and sums them up.

use std::ffi::OsStr;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::repository::root;

/// A chore ends well, or with what failed and what to try.
pub type Outcome = Result<(), String>;

/// The steps so far.
pub struct Steps {
    begun: Instant,
    done: Vec<(&'static str, Duration, bool)>,
}

impl Steps {
    pub fn new() -> Self {
        Self { begun: Instant::now(), done: Vec::new() }
    }

    /// Notes a step that took so long, beside another one.
    pub fn took(&mut self, name: &'static str, took: Duration, outcome: Outcome) -> Outcome {
        self.done.push((name, took, outcome.is_ok()));
        println!("==> {name}: {} in {:.1} s", verdict(outcome.is_ok()), took.as_secs_f64());
        outcome.map_err(|message| format!("{name} failed: {message}"))
    }

    /// Runs one step; its failure is that of the whole.
    pub fn run(&mut self, name: &'static str, step: impl FnOnce() -> Outcome) -> Outcome {
        println!("\n==> {name}");
        let start = Instant::now();
        let outcome = step();
        self.took(name, start.elapsed(), outcome)
    }

    /// One line a step, and how long all of them took.
    pub fn print_summary(&self) {
        println!("\n{:<16} {:>8}  result", "step", "seconds");
        for (name, took, good) in &self.done {
            println!("{name:<16} {:>8.1}  {}", took.as_secs_f64(), verdict(*good));
        }
        let total = self.begun.elapsed();
        let good = self.done.iter().all(|(_, _, good)| *good);
        println!("{:<16} {:>8.1}  {}", "total", total.as_secs_f64(), verdict(good));
    }
}

fn verdict(good: bool) -> &'static str {
    if good { "ok" } else { "FAILED" }
}

/// Cargo in the root.
pub fn cargo_command<S: AsRef<OsStr>>(args: &[S]) -> Command {
    let mut command = Command::new("cargo");
    command.args(args).current_dir(root());
    if std::env::var_os("CI").is_some() {
        // Nobody builds there twice.
        for (name, value) in [("CARGO_INCREMENTAL", "0"), ("CARGO_TERM_COLOR", "never")] {
            if std::env::var_os(name).is_none() {
                command.env(name, value);
            }
        }
    }
    command
}

/// Runs cargo in the root; `advice` is what to do if it fails.
pub fn cargo<S: AsRef<OsStr>>(args: &[S], variables: &[(&str, &str)], advice: &str) -> Outcome {
    run(cargo_command(args).envs(variables.iter().copied()), advice)
}

/// Runs a command; `advice` is what to do if it fails.
pub fn run(command: &mut Command, advice: &str) -> Outcome {
    let line = std::iter::once(command.get_program())
        .chain(command.get_args())
        .map(|part| part.to_string_lossy())
        .collect::<Vec<_>>()
        .join(" ");
    println!("    {line}");
    let status = command.status().map_err(|error| format!("cannot run `{line}`: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("`{line}`: {status}\n       {advice}")) }
}
