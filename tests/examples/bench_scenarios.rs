//! The shipped scenarios: is the cause of each named, and is nothing saved that makes the next straight worse?
//! `cargo xtask bench scenarios [--seeds N] [--only NAME] [--skip explain|saving]`; ten seeds of each by default.

use std::process::ExitCode;

use beeline_tests::parallel::in_order;
use beeline_tests::scenarios::cause::{Cause, Named, named};
use beeline_tests::scenarios::saving::{Procedure, Saved, saved_by};
use beeline_tests::scenarios::{names, shipped};

fn main() -> ExitCode {
    let arguments = match Arguments::read() {
        Ok(arguments) => arguments,
        Err(why) => {
            eprintln!(
                "{why}\nusage: bench_scenarios [--seeds N] [--only NAME] [--skip explain|saving]"
            );
            return ExitCode::from(2);
        }
    };
    let only = |name: &String| arguments.only.as_ref().is_none_or(|only| only == name);
    let mut counts = Counts::default();
    for name in names().into_iter().filter(only) {
        println!("== {name}");
        if arguments.skip != "explain" {
            explain(&name, &arguments.seeds, &mut counts);
        }
        if arguments.skip != "saving" {
            for procedure in Procedure::ALL {
                save(&name, procedure, &arguments.seeds, &mut counts);
            }
        }
    }
    counts.report()
}

/// The command line.
struct Arguments {
    seeds: Vec<u64>,
    only: Option<String>,
    skip: String,
}

impl Arguments {
    fn read() -> Result<Self, String> {
        let (mut seeds, mut only, mut skip) = (10, None, String::new());
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            let value = words.next().ok_or(format!("{word} needs a value"))?;
            match word.as_str() {
                "--seeds" => seeds = value.parse().map_err(|_| format!("{value}: not a number"))?,
                "--only" => only = Some(value),
                "--skip" => skip = value,
                _ => return Err(format!("unknown argument {word}")),
            }
        }
        Ok(Self { seeds: (1..=seeds).collect(), only, skip })
    }
}

/// Over all robots.
#[derive(Default)]
struct Counts {
    explained: usize,
    unnamed: usize,
    not_first: usize,
    not_largest: usize,
    besides: usize,
    procedures: usize,
    saved: usize,
    worse: usize,
    failed: usize,
}

impl Counts {
    fn report(&self) -> ExitCode {
        let Self { explained, procedures, saved, .. } = self;
        println!(
            "\n{explained} campaigns; {procedures} procedures, of which {saved} saved a number"
        );
        let mut good = true;
        for (claim, failures) in [
            ("every cause is named", self.unnamed),
            ("a cause is the first that matters, in order of evidence", self.not_first),
            ("a cause is worth most", self.not_largest),
            ("nothing else matters", self.besides),
            ("no saved number makes the next straight worse", self.worse),
            ("every procedure ends", self.failed),
        ] {
            good &= failures == 0;
            let verdict = if failures == 0 { "holds " } else { "MISSED" };
            println!("{verdict} {claim}: {failures} failures");
        }
        if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }
}

fn explain(name: &str, seeds: &[u64], counts: &mut Counts) {
    let Some(cause) = Cause::of(name) else {
        println!("    nobody has said what is wrong here");
        counts.failed += 1;
        return;
    };
    let results = in_order(seeds, |seed| named(&shipped(name, *seed), cause));
    counts.explained += results.len();
    for (seed, result) in seeds.iter().zip(results) {
        let Named { missing, besides, is_first, is_largest, said } = match result {
            Ok(named) => named,
            Err(why) => {
                println!("{seed:>3} FAILED {why}");
                counts.failed += 1;
                continue;
            }
        };
        counts.unnamed += usize::from(!missing.is_empty());
        counts.not_first += usize::from(!is_first);
        counts.not_largest += usize::from(!is_largest);
        counts.besides += usize::from(!besides.is_empty());
        let mut remarks = Vec::new();
        if !missing.is_empty() {
            remarks.push(format!("MISSING {}", missing.join(", ")));
        }
        remarks.extend((!is_first).then(|| "NOT FIRST".to_string()));
        remarks.extend((!is_largest).then(|| "NOT LARGEST".to_string()));
        if !besides.is_empty() {
            let ids: Vec<&str> = besides.iter().map(|(id, _)| id.as_str()).collect();
            remarks.push(format!("BESIDES {}", ids.join(", ")));
        }
        println!("{seed:>3} {said}  {}", remarks.join("; "));
    }
}

fn save(name: &str, procedure: Procedure, seeds: &[u64], counts: &mut Counts) {
    let results = in_order(seeds, |seed| saved_by(&shipped(name, *seed), procedure));
    let (mut decisions, mut before_mm, mut after_mm) = (Vec::<(String, usize)>::new(), 0.0, 0.0);
    let (mut saved, mut worse) = (0_u32, 0_usize);
    for (seed, result) in seeds.iter().zip(&results) {
        let done = match result {
            Ok(done) => done,
            Err(why) => {
                println!("{seed:>3} {:<22} FAILED {why}", procedure.name());
                counts.failed += 1;
                continue;
            }
        };
        let decision = done.decision.split(" at ").next().unwrap_or_default();
        match decisions.iter_mut().find(|(words, _)| words == decision) {
            Some((_, count)) => *count += 1,
            None => decisions.push((decision.to_string(), 1)),
        }
        if let Saved { saved: true, before_m, after_m, .. } = done {
            saved += 1;
            before_mm += before_m.abs() * 1e3;
            after_mm += after_m.abs() * 1e3;
        }
        worse += usize::from(done.is_worse());
    }
    counts.procedures += results.len();
    counts.saved += saved as usize;
    counts.worse += worse;
    let decisions: Vec<String> =
        decisions.iter().map(|(words, count)| format!("{count} {words}")).collect();
    let straights = match saved {
        0 => String::new(),
        n => format!(
            "{:.2} -> {:.2} mm, {worse} worse",
            before_mm / f64::from(n),
            after_mm / f64::from(n)
        ),
    };
    println!(
        "    {:<22} saved {saved:>2} {straights:<30} {}",
        procedure.name(),
        decisions.join("; ")
    );
}
