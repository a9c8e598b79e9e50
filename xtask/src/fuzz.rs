//! `cargo xtask fuzz`: the coverage-guided search for inputs that break a fuzz target, with libFuzzer.
//!
//! It needs no other compiler than the tests: instrumenting for coverage is a pass of LLVM that the stable compiler has.
//! libFuzzer itself comes as the source of a crate, in C++.
//!
//! | where | what |
//! | --- | --- |
//! | `fuzz/corpus/TARGET/` | where the search begins; in the repository, small |
//! | `fuzz/dictionary/` | words of the formats |
//! | the build folder's `fuzz/found/TARGET/` | inputs that reached new code: the next search goes on from them |
//! | the build folder's `fuzz/broken/` | inputs that broke a target, and what libFuzzer said |

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::prerequisites;
use crate::repository::{root, target_folder};
use crate::steps::{Outcome, cargo, run as command};

/// LLVM's coverage of edges, and of what comparisons compare.
const COVERAGE: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares";

/// One input may take this long \[s\], and a target this much memory \[MB\].
const INPUT_LIMITS: [&str; 2] = ["-timeout=5", "-rss_limit_mb=1500"];

/// The search of each target, unless the command says otherwise \[s\].
const SECONDS: u32 = 60;

/// What is asked for.
#[derive(Debug, PartialEq)]
struct Search {
    target: Option<String>,
    seconds: u32,
    minimise: bool,
}

impl Search {
    fn parse(args: &[&str]) -> Result<Self, String> {
        let mut search = Self { target: None, seconds: SECONDS, minimise: false };
        let mut args = args.iter();
        while let Some(&arg) = args.next() {
            match arg {
                "--seconds" => {
                    let given = args.next().and_then(|text| text.parse().ok());
                    search.seconds = given.ok_or("--seconds needs a whole number")?;
                }
                "--minimise" => search.minimise = true,
                name if !name.starts_with('-') && search.target.is_none() => {
                    search.target = Some(name.into());
                }
                other => return Err(format!("fuzz does not know `{other}`; `cargo xtask help`")),
            }
        }
        Ok(search)
    }
}

/// One target, as the program lists it.
struct Target {
    name: String,
    len_max: String,
    dictionary: Option<String>,
}

/// Searches, and prints executions and coverage of each target.
pub fn run(args: &[&str]) -> Outcome {
    let search = Search::parse(args)?;
    prerequisites::meet_for_fuzzing()?;
    let program = build()?;
    let all = list(&program)?;
    let chosen: Vec<&Target> = all
        .iter()
        .filter(|target| search.target.as_ref().is_none_or(|name| *name == target.name))
        .collect();
    if chosen.is_empty() {
        let names: Vec<&str> = all.iter().map(|target| target.name.as_str()).collect();
        let name = search.target.unwrap_or_default();
        return Err(format!("no target `{name}`\n       targets: {}", names.join(", ")));
    }
    let mut broken = Vec::new();
    println!(
        "{:<12} {:>12} {:>8} {:>9} {:>7}",
        "target", "executions", "edges", "features", "inputs"
    );
    for target in chosen {
        let log = target.search(&program, search.seconds)?;
        let figures = summary(&log);
        println!("{:<12} {figures}", target.name);
        if figures == NOTHING {
            broken.push(format!(
                "{}: {NOTHING}: {}",
                target.name,
                log.lines().last().unwrap_or("")
            ));
        } else if let Some(finding) = finding(&log) {
            broken.push(format!("{}: {finding}", target.name));
        } else if search.minimise {
            target.minimise(&program)?;
        }
    }
    if broken.is_empty() {
        return Ok(());
    }
    let place = folder().join("broken");
    Err(format!(
        "inputs that break their targets are in {}:\n{}",
        place.display(),
        broken.join("\n")
    ))
}

fn folder() -> PathBuf {
    target_folder().join("fuzz")
}

/// Compiles the program that has all targets, in a build folder of its own: nothing else is instrumented.
fn build() -> Result<PathBuf, String> {
    let host = host()?;
    let target_dir = folder();
    let target_dir = target_dir.to_str().ok_or("the build folder's name is not UTF-8")?;
    let line = [
        "build",
        "--profile",
        "fuzz",
        "-p",
        "beeline-fuzz",
        "--features",
        "libfuzzer",
        "--bin",
        "coverage_guided",
        "--target",
        &host,
        "--target-dir",
        target_dir,
    ];
    cargo(&line, &[("RUSTFLAGS", COVERAGE)], "fix the build")?;
    Ok(folder().join(host).join("fuzz/coverage_guided"))
}

/// The compiler's own target: named, so that build scripts and macros are not instrumented.
fn host() -> Result<String, String> {
    let output = Command::new("rustc")
        .arg("-vV")
        .current_dir(root())
        .output()
        .map_err(|error| format!("cannot run rustc: {error}"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| format!("rustc does not say its host:\n{text}"))
}

fn list(program: &Path) -> Result<Vec<Target>, String> {
    let output = Command::new(program)
        .env_remove("BEELINE_FUZZ_TARGET")
        .output()
        .map_err(|error| format!("cannot run {}: {error}", program.display()))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let target = |line: &str| {
        let mut words = line.split(' ').map(str::to_owned);
        let (name, len_max) = (words.next()?, words.next()?);
        let dictionary = words.next().filter(|word| word != "-");
        Some(Target { name, len_max, dictionary })
    };
    Ok(text.lines().filter_map(target).collect())
}

impl Target {
    fn found(&self) -> PathBuf {
        folder().join("found").join(&self.name)
    }

    fn corpus(&self) -> PathBuf {
        root().join("fuzz/corpus").join(&self.name)
    }

    /// libFuzzer on this target.
    fn program(&self, program: &Path) -> Command {
        let mut line = Command::new(program);
        line.env("BEELINE_FUZZ_TARGET", &self.name).args(INPUT_LIMITS);
        line.arg(format!("-max_len={}", self.len_max));
        line
    }

    /// Searches for some seconds; what libFuzzer said.
    fn search(&self, program: &Path, seconds: u32) -> Result<String, String> {
        let broken = folder().join("broken");
        for place in [&self.found(), &broken] {
            fs::create_dir_all(place).map_err(|e| format!("{}: {e}", place.display()))?;
        }
        let log = broken.join(format!("{}.log", self.name));
        let output = File::create(&log).map_err(|e| format!("{}: {e}", log.display()))?;
        let mut line = self.program(program);
        line.arg(format!("-max_total_time={seconds}")).arg("-print_final_stats=1");
        line.arg(format!("-artifact_prefix={}/{}-", broken.display(), self.name));
        if let Some(name) = &self.dictionary {
            let file = root().join("fuzz/dictionary").join(name).with_extension("dict");
            line.arg(format!("-dict={}", file.display()));
        }
        // A search that ends with a finding ends with an error: the log says which.
        line.arg(self.found())
            .arg(self.corpus())
            .stderr(output)
            .status()
            .map_err(|e| e.to_string())?;
        let bytes = fs::read(&log).map_err(|e| format!("{}: {e}", log.display()))?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// Keeps, in the repository, the fewest inputs that reach all edges that any input has reached.
    fn minimise(&self, program: &Path) -> Outcome {
        let kept = folder().join("kept").join(&self.name);
        let fail = |error: std::io::Error| format!("{}: {error}", kept.display());
        if kept.exists() {
            fs::remove_dir_all(&kept).map_err(fail)?;
        }
        fs::create_dir_all(&kept).map_err(fail)?;
        let mut line = self.program(program);
        // Edges alone: how often each is passed makes ten times as many inputs.
        line.arg("-set_cover_merge=1").arg("-use_counters=0");
        line.arg(&kept).arg(self.corpus()).arg(self.found());
        let log = folder().join("kept").join(format!("{}.log", self.name));
        line.stderr(File::create(log).map_err(fail)?);
        command(&mut line, "libFuzzer could not merge the inputs")?;
        fs::remove_dir_all(self.corpus()).map_err(fail)?;
        fs::create_dir_all(self.corpus()).map_err(fail)?;
        for entry in fs::read_dir(&kept).map_err(fail)?.flatten() {
            // Half of the hash that libFuzzer names an input by: short, and no two alike.
            let name = entry.file_name().to_string_lossy().chars().take(16).collect::<String>();
            fs::copy(entry.path(), self.corpus().join(name)).map_err(fail)?;
        }
        Ok(())
    }
}

/// What the table says of a search that did not begin.
const NOTHING: &str = "no input was run";

/// Executions, edges, features and inputs, as libFuzzer's last line about them says.
fn summary(log: &str) -> String {
    let last = log.lines().rev().find(|line| line.starts_with('#') && line.contains(" cov: "));
    let Some(last) = last else { return NOTHING.into() };
    let words: Vec<&str> = last.split_whitespace().collect();
    let after = |name: &str| {
        let at = words.iter().position(|word| *word == name);
        at.and_then(|at| words.get(at + 1)).copied().unwrap_or("-")
    };
    let executions = words[0].trim_start_matches('#');
    let inputs = after("corp:").split('/').next().unwrap_or("-");
    format!("{executions:>12} {:>8} {:>9} {inputs:>7}", after("cov:"), after("ft:"))
}

/// What broke, if something did: the panic's message, or libFuzzer's own word for it.
fn finding(log: &str) -> Option<String> {
    let summary = log.lines().find(|line| line.starts_with("SUMMARY:"))?;
    let mut lines = log.lines().skip_while(|line| !line.contains(" panicked at "));
    let panic = lines.next().map(|at| format!("{at} {}", lines.next().unwrap_or_default()));
    Some(panic.unwrap_or_else(|| summary.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_says_what_is_searched_and_for_how_long() {
        let parsed = |args: &[&str]| Search::parse(args).unwrap();
        assert_eq!(parsed(&[]), Search { target: None, seconds: SECONDS, minimise: false });
        let all = parsed(&["frames", "--seconds", "5", "--minimise"]);
        assert_eq!(all, Search { target: Some("frames".into()), seconds: 5, minimise: true });
        for wrong in [&["--second"][..], &["--seconds"], &["--seconds", "x"], &["a", "b"]] {
            assert!(Search::parse(wrong).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn what_libfuzzer_says_is_summed_up() {
        let good = "#8\tINITED cov: 2 ft: 3 corp: 1/1b\n#402321\tDONE   cov: 85 ft: 477 corp: 134/32Kb lim: 2\n";
        let words: Vec<String> = summary(good).split_whitespace().map(String::from).collect();
        assert_eq!(words, ["402321", "85", "477", "134"]);
        assert_eq!(finding(good), None);
        let bad = "\nthread '<unnamed>' panicked at fuzz/src/x.rs:1:2:\nit still moves\nSUMMARY: libFuzzer: deadly\n";
        assert!(finding(bad).unwrap().ends_with("x.rs:1:2: it still moves"));
        assert_eq!(
            finding("SUMMARY: libFuzzer: timeout\n").unwrap(),
            "SUMMARY: libFuzzer: timeout"
        );
    }
}
