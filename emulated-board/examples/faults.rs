//! `cargo xtask bench faults [--seed S] [--cases N [--first I]] [--case I] [--threads T]`: random faults at random instants,
//! on the flashed image.

use std::collections::BTreeMap;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use emulated_board::random_faults::{Case, Name, Verdict, run};

const USE: &str =
    "use: cargo xtask bench faults [--seed S] [--cases N [--first I]] [--case I] [--threads T]";

struct Options {
    seed: u64,
    first: u64,
    cases: u64,
    case: Option<u64>,
    threads: usize,
}

impl Options {
    fn parse() -> Result<Self, String> {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let mut options = Self { seed: 1, first: 0, cases: 2000, case: None, threads };
        let mut args = std::env::args().skip(1);
        while let Some(option) = args.next() {
            let value = args.next().ok_or(format!("{option} needs a value\n{USE}"))?;
            let number =
                value.parse().map_err(|_| format!("{option} {value}: not a number\n{USE}"));
            match option.as_str() {
                "--seed" => options.seed = number?,
                "--cases" => options.cases = number?,
                "--first" => options.first = number?,
                "--case" => options.case = Some(number?),
                "--threads" => options.threads = number?.max(1) as usize,
                _ => return Err(format!("unknown option {option}\n{USE}")),
            }
        }
        Ok(options)
    }
}

fn main() -> ExitCode {
    let options = Options::parse();
    let image = std::env::var_os("BEELINE_IMAGE").ok_or("run this by `cargo xtask bench faults`");
    let (options, image) = match (options, image) {
        (Ok(options), Ok(image)) => (options, PathBuf::from(image)),
        (Err(why), _) => return complain(&why),
        (_, Err(why)) => return complain(why),
    };
    let indices = match options.case {
        Some(case) => case..case + 1,
        None => options.first..options.first + options.cases,
    };
    println!("seed {}, cases {} to {}", options.seed, indices.start, indices.end - 1);
    let results = run_all(&image, options.seed, indices, options.threads);
    if options.case.is_some() {
        for (case, verdict) in &results {
            println!("{case:#?}\n{verdict:#?}");
        }
    }
    report(&results)
}

fn complain(why: &str) -> ExitCode {
    eprintln!("{why}");
    ExitCode::from(2)
}

type Outcome = (Case, Result<Verdict, String>);

/// A case takes seconds. One that has not ended after this long never will.
const ENDS_WITHIN: Duration = Duration::from_secs(300);

/// The cases that are done, by number, and those that run, since when.
#[derive(Default)]
struct Progress {
    done: BTreeMap<u64, Outcome>,
    running: BTreeMap<u64, Instant>,
}

/// Runs the cases on several threads; in order. A case that does not end is given up, and is wrong.
fn run_all(image: &Path, seed: u64, indices: std::ops::Range<u64>, threads: usize) -> Vec<Outcome> {
    let (next, begin) = (Arc::new(AtomicU64::new(indices.start)), Instant::now());
    let (all, len) = (Arc::new(Mutex::new(Progress::default())), indices.end - indices.start);
    for _ in 0..threads {
        let (image, next, all) = (image.to_owned(), Arc::clone(&next), Arc::clone(&all));
        std::thread::spawn(move || {
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                if index >= indices.end {
                    return;
                }
                all.lock().expect("no thread panics").running.insert(index, Instant::now());
                let case = Case::draw(seed, index);
                let verdict = run(&image, &case);
                if !is_good(&verdict) {
                    // Also of a bench that is ended early.
                    eprintln!("\nwrong: {}", case.command());
                }
                let mut all = all.lock().expect("no thread panics");
                all.running.remove(&index);
                all.done.insert(index, (case, verdict));
                progress(&all.done, len, begin);
            }
        });
    }
    loop {
        std::thread::sleep(Duration::from_millis(20));
        let mut all = all.lock().expect("no thread panics");
        let hang = all.running.values().filter(|begun| begun.elapsed() > ENDS_WITHIN).count();
        let left = len - all.done.len() as u64;
        // What hangs keeps its thread.
        if left == 0 || left == hang as u64 || hang == threads {
            if std::io::stderr().is_terminal() {
                eprintln!();
            }
            for index in std::mem::take(&mut all.running).into_keys() {
                let error = format!("it did not end within {} s", ENDS_WITHIN.as_secs());
                all.done.insert(index, (Case::draw(seed, index), Err(error)));
            }
            return std::mem::take(&mut all.done).into_values().collect();
        }
    }
}

/// Shows how many cases are done, and how many of them are wrong.
fn progress(done: &BTreeMap<u64, Outcome>, of: u64, begin: Instant) {
    let terminal = std::io::stderr().is_terminal();
    if !terminal && !done.len().is_multiple_of(20) {
        return;
    }
    let wrong = done.values().filter(|(_, verdict)| !is_good(verdict)).count();
    let s = begin.elapsed().as_secs_f64();
    let (before, after) = if terminal { ("\r", "") } else { ("", "\n") };
    eprint!("{before}{} of {of} cases, {wrong} wrong, {s:.0} s{after}", done.len());
    let _ = std::io::stderr().flush();
}

fn is_good(verdict: &Result<Verdict, String>) -> bool {
    verdict.as_ref().is_ok_and(|verdict| verdict.wrong.is_empty())
}

/// What is printed of a kind.
#[derive(Default)]
struct Row {
    cases: usize,
    driven: usize,
    /// Of the case that came closest to its bound: when the motors were off, and the bound \[ms\].
    worst_ms: f64,
    bound_ms: Option<f64>,
    share: f64,
    names: BTreeMap<String, usize>,
}

impl Row {
    fn add(&mut self, verdict: &Verdict) {
        self.cases += 1;
        self.driven += usize::from(verdict.was_driven);
        if let Some(bound_ms) = verdict.bound_ms {
            let share = verdict.off_ms / bound_ms;
            if share >= self.share {
                (self.share, self.bound_ms) = (share, Some(bound_ms));
                self.worst_ms = verdict.off_ms;
            }
        }
        for name in &verdict.names {
            *self.names.entry(without_wheel(name)).or_default() += 1;
        }
    }
}

fn without_wheel(name: &Name) -> String {
    match name {
        Name::Fault(fault) => fault.id().into(),
        other => other.to_string(),
    }
}

fn report(results: &[Outcome]) -> ExitCode {
    let mut rows: BTreeMap<String, Row> = BTreeMap::new();
    for (case, verdict) in results {
        if let Ok(verdict) = verdict {
            let name = match case.second {
                None => case.first.name(),
                Some(_) => "two of them".into(),
            };
            rows.entry(name).or_default().add(verdict);
        }
    }
    println!(
        "{:<30} {:>5} {:>7} {:>10} {:>9}  names",
        "what happens", "cases", "driven", "worst [ms]", "bound"
    );
    for (name, row) in &rows {
        let names: Vec<String> =
            row.names.iter().map(|(name, count)| format!("{name} {count}")).collect();
        let (worst, bound) = match row.bound_ms {
            Some(bound_ms) => (format!("{:.2}", row.worst_ms), format!("{bound_ms:.1}")),
            None => ("-".into(), "-".into()),
        };
        let Row { cases, driven, .. } = row;
        println!("{name:<30} {cases:>5} {driven:>7} {worst:>10} {bound:>9}  {}", names.join(", "));
    }
    let wrong: Vec<&Outcome> = results.iter().filter(|(_, verdict)| !is_good(verdict)).collect();
    println!("\n{} cases, {} wrong", results.len(), wrong.len());
    for (case, verdict) in &wrong {
        let second = case.second.map_or(String::new(), |(second, later_us)| {
            format!(", {:.2} ms later {}", later_us as f64 / 1000.0, second.name())
        });
        let delay_ms = case.delay_us as f64 / 1000.0;
        println!("{}", case.command());
        println!("    {:?} + {delay_ms:.2} ms: {}{second}", case.phase, case.first.name());
        match verdict {
            Ok(verdict) => verdict.wrong.iter().for_each(|wrong| println!("    {wrong}")),
            Err(error) => println!("    could not be run: {error}"),
        }
    }
    if wrong.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
