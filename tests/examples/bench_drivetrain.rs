//! Effects hidden in motors, gears, drivers and batteries: how often `explain --drivetrain` names them.
//! `cargo xtask bench drivetrain [--seed S] [--campaigns N [--first I]]`; seed 1 and 60 campaigns by default. `--case N` repeats one.

use std::process::ExitCode;

use beeline_tests::drivetrain::case::{Case, Kind};
use beeline_tests::drivetrain::score::{Score, judge};
use beeline_tests::parallel::in_order;

fn main() -> ExitCode {
    let Some((seed, numbers)) = arguments() else {
        eprintln!("usage: bench_drivetrain [--seed S] [--campaigns N [--first I] | --case N]");
        return ExitCode::from(2);
    };
    let scores = in_order(&numbers, |number| {
        let score = judge(seed, &Case::draw(seed, *number));
        println!("{number}: {}", score.text);
        score
    });
    print(&scores);
    list_misses(&numbers, &scores);
    ExitCode::SUCCESS
}

fn arguments() -> Option<(u64, Vec<u64>)> {
    let (mut seed, mut campaigns, mut first, mut case) = (1, 60, 0, None);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let value = words.next()?.parse().ok()?;
        match word.as_str() {
            "--seed" => seed = value,
            "--campaigns" => campaigns = value,
            "--first" => first = value,
            "--case" => case = Some(value),
            _ => return None,
        }
    }
    Some((seed, case.map_or((first..first + campaigns).collect(), |case| vec![case])))
}

fn print(scores: &[Score]) {
    let of = |kinds: &[Kind]| {
        let of_kinds = scores.iter().filter(|score| kinds.contains(&score.kind));
        let told: Vec<bool> = of_kinds.filter_map(|score| score.right).collect();
        (told.iter().filter(|right| **right).count(), told.len())
    };
    println!();
    for (what, bar, kinds) in [
        ("one effect, strong: named or in the class", "95 %", [Kind::Strong].as_slice()),
        ("one effect, weak", "80 %", &[Kind::Weak]),
        ("two effects, both", "85 %", &[Kind::Two]),
        ("nothing: no effect and no flag", "95 %", &[Kind::Nothing]),
        ("outside: flagged, or as good as without it", "90 %", &[Kind::Outside]),
    ] {
        let (right, all) = of(kinds);
        println!("{what:<46}{:5.1} % of {all:<4} bar {bar}", share(right, all));
    }
    let inside = scores.iter().filter(|score| score.kind != Kind::Outside && score.right.is_some());
    let alarms: Vec<bool> = inside.map(|score| score.false_alarm).collect();
    let count = alarms.iter().filter(|alarm| **alarm).count();
    println!(
        "{:<46}{:5.1} % of {:<4} bar 5 %",
        "an effect too many, of the catalogue's",
        share(count, alarms.len()),
        alarms.len()
    );
    let covers: Vec<bool> = scores.iter().flat_map(|score| score.covers.clone()).collect();
    let held = covers.iter().filter(|held| **held).count();
    println!(
        "{:<46}{:5.1} % of {:<4} bar 90 to 98 %",
        "95 % intervals hold the plant's number",
        share(held, covers.len()),
        covers.len()
    );
    println!("refused: {}", scores.iter().filter(|score| score.right.is_none()).count());
}

fn list_misses(numbers: &[u64], scores: &[Score]) {
    println!();
    for (number, score) in numbers.iter().zip(scores) {
        if score.right != Some(true) || score.false_alarm || score.covers.contains(&false) {
            println!("missed {number}: {}", score.text);
        }
    }
}

fn share(count: usize, all: usize) -> f64 {
    100.0 * count as f64 / all.max(1) as f64
}
