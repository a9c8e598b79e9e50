//! The project's own chores: `cargo xtask help`.

mod arrows;
mod bench;
mod boards;
mod circles;
mod dependencies;
mod documents;
mod emulated;
#[cfg(test)]
mod example;
mod firmware;
mod fuzz;
mod lengths;
mod needs;
mod source;
mod steps;
mod test;
mod test_binaries;
mod third_party;
mod words;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::OnceLock;

const HELP: &str = "\
cargo xtask <chore>

  test               installs what is missing, then runs all that CI runs
  check              the part of it that takes seconds: format, words, pages, lengths, circles
  firmware [--board NAME] [--compiler pinned|distribution]
                     builds the boards' images and prints how large they are
  bench firmware     counts the instructions of a control tick, on the emulated board
  bench faults [--seed S] [--cases N] [--case I] [--threads T]
                     random faults at random instants on the emulated board: are the motors off
                     in time, and is each called what it is?
  fuzz [TARGET] [--seconds S] [--minimise]
                     searches for inputs that break a fuzz target, or each of them, guided by coverage;
                     `--minimise` then keeps the fewest that reach the same code, in fuzz/corpus
  bench crash        ends every command that writes at every system call that changes the file system
                     (Linux on x86-64): is what is left old or new, and does it complete afterwards?
  emulate [--listen HOST:PORT] [--scenario FILE] [--camera FILE] [--flash FILE]
                     the emulated board behind TCP, for `beeline --port tcp:HOST:PORT`
  bench NAME [ARGS]  runs tests/examples/bench_NAME.rs as a release build; `all` runs every one of
                     these, which firmware, faults and crash are none of
  arrows             draws which folder of robot-model uses which, into ARCHITECTURE.md
  dependencies       licences, sources and duplicates of what is depended on, by the rules of deny.toml
  third-party        writes THIRD-PARTY.txt, the notice of whose code is in the programs
  boards             writes the pin tables and wiring pictures in docs/boards/
  help               this
";

/// A chore ends well, or with what failed and what to try.
type Outcome = Result<(), String>;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let outcome = match args[..] {
        ["test"] => test::run(),
        ["dependencies"] => dependencies::check(),
        ["third-party"] => third_party::run(),
        ["arrows"] => arrows::run(),
        ["boards"] => boards::write(),
        ["check"] => test::check(),
        ["firmware", ref args @ ..] => firmware::run(args),
        ["fuzz", ref args @ ..] => fuzz::run(args),
        ["emulate", ref args @ ..] => emulated::serve(args),
        ["bench", "firmware"] => emulated::bench(),
        ["bench", "faults", ref args @ ..] => emulated::bench_faults(args),
        ["bench", "crash"] => bench::crash(),
        ["bench", name, ref args @ ..] => bench::run(name, args),
        ["bench"] => Err(bench::listing("which one?")),
        ["help" | "--help" | "-h"] | [] => {
            print!("{HELP}");
            Ok(())
        }
        [chore, ..] => {
            Err(format!("no chore `{}`\n\n{HELP}", [&[chore], &args[1..]].concat().join(" ")))
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// The repository's root.
///
/// Asked at run time: with one build folder for two checkouts, cargo may run the program built in the other.
fn root() -> &'static Path {
    static ROOT: OnceLock<PathBuf> = OnceLock::new();
    ROOT.get_or_init(|| {
        let package = std::env::var_os("CARGO_MANIFEST_DIR")
            .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
        package.parent().expect("xtask lies in the root").to_path_buf()
    })
}

/// Where everything is built.
fn target_folder() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| root().join("target"), |folder| root().join(folder))
}

/// The files that git tracks, or would track when everything is added; relative to the root.
fn tracked_files() -> Result<Vec<PathBuf>, String> {
    let output = std::process::Command::new("git")
        .args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"])
        .current_dir(root())
        .output()
        .map_err(|error| format!("cannot run git ({error}): install it"))?;
    if !output.status.success() {
        return Err(format!("git ls-files: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    let list = String::from_utf8(output.stdout).map_err(|_| "a file name is not UTF-8")?;
    let files = list.split_terminator('\0').map(PathBuf::from);
    Ok(files.filter(|file| root().join(file).is_file()).collect())
}
