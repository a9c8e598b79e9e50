//! How straight do robots drive after a calibration? 200 robots drawn by seed, each calibrated once with the camera
//! and once with the ruler, compared with the truth: `cargo xtask bench calibration`.

use std::collections::BTreeMap;
use std::process::ExitCode;

use beeline_tests::calibration::{CalibrationOutcome, Instrument, quartiles, verdicts_on};

/// The lateral error's median must fall by this factor with the camera.
const FACTOR_MIN: f64 = 20.0;
/// The ruler's 95 % interval must cover the truth in this share.
const COVERAGE: std::ops::RangeInclusive<f64> = 0.90..=0.98;

fn main() -> ExitCode {
    let (robots, seed) = match arguments() {
        Ok(arguments) => arguments,
        Err(why) => {
            eprintln!("{why}\nusage: bench_calibration [--robots N] [--seed S]");
            return ExitCode::from(2);
        }
    };
    let seeds: Vec<u64> = (seed..seed + robots).collect();
    println!("{robots} robots, seeds {seed} to {}: R_R/R_L from 0.985 to 1.015", seed + robots - 1);
    println!("lateral error at the end of the eight revolutions, true, from the true start\n");
    println!(
        "{:<8} {:>8} {:>8} {:>8}   {:>8} {:>8} {:>8}   {:>9} {:>8} {:>8}",
        "", "before", "after", "", "factor", "", "", "sigma", "error", "95 %"
    );
    println!(
        "{:<8} {:>8} {:>8} {:>8}   {:>8} {:>8} {:>8}   {:>9} {:>8} {:>8}",
        "",
        "median",
        "median",
        "worst",
        "lower q.",
        "median",
        "upper q.",
        "of W_T",
        "rms",
        "covers"
    );
    let camera = report("camera", &seeds, Instrument::Camera);
    let ruler = report("ruler", &seeds, Instrument::Ruler);
    println!(
        "{:<8} {:>8} {:>8} {:>8}   {:>8} {:>8} {:>8}   Borenstein & Feng 1996, for scale",
        "UMBmark", "", "", "", "10", "", "22"
    );
    let mut good = camera.failed.is_empty() && ruler.failed.is_empty();
    good &= bar("the camera's median factor is 20 or better", camera.factor >= FACTOR_MIN);
    good &= bar("the ruler's interval covers 90 to 98 %", COVERAGE.contains(&ruler.coverage));
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn arguments() -> Result<(u64, u64), String> {
    let (mut robots, mut seed) = (200, 1);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut number = || -> Result<u64, String> {
            let value = words.next().ok_or(format!("{word} needs a number"))?;
            value.parse().map_err(|_| format!("{word} {value}: not a number"))
        };
        match word.as_str() {
            "--robots" => robots = number()?.max(1),
            "--seed" => seed = number()?,
            _ => return Err(format!("unknown argument {word}")),
        }
    }
    Ok((robots, seed))
}

/// The figures of the bars.
struct Figures {
    factor: f64,
    coverage: f64,
    failed: Vec<u64>,
}

fn report(name: &str, seeds: &[u64], instrument: Instrument) -> Figures {
    let results = verdicts_on(seeds, instrument);
    let good: Vec<&CalibrationOutcome> = results.iter().flatten().collect();
    let column = |f: fn(&CalibrationOutcome) -> f64| {
        good.iter().map(|verdict| f(verdict)).collect::<Vec<f64>>()
    };
    let mm = |f: fn(&CalibrationOutcome) -> f64| quartiles(&column(f))[1] * 1e3;
    let factor = quartiles(&column(CalibrationOutcome::factor));
    let worst_mm = column(|v| v.after_m.abs()).into_iter().fold(0.0, f64::max) * 1e3;
    let errors = column(CalibrationOutcome::error_sigmas);
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    let coverage = good.iter().filter(|v| v.covered).count() as f64 / good.len() as f64;
    println!(
        "{name:<8} {:>5.2} mm {:>5.2} mm {worst_mm:>5.2} mm   {:>8.1} {:>8.1} {:>8.1}   {:>9.6} {rms:>6.2} s {:>6.1} %",
        mm(|v| v.before_m.abs()),
        mm(|v| v.after_m.abs()),
        factor[0],
        factor[1],
        factor[2],
        quartiles(&column(|v| v.sigma))[1],
        coverage * 100.0,
    );
    let mut others: BTreeMap<&str, Vec<u64>> = BTreeMap::new();
    for verdict in good.iter().filter(|v| v.decision != "corrected") {
        others.entry(verdict.decision).or_default().push(verdict.seed);
    }
    for (decision, those) in others {
        println!("         {decision}: seeds {those:?}");
    }
    let outside: Vec<u64> = good.iter().filter(|v| !v.covered).map(|v| v.seed).collect();
    println!("         outside the interval: seeds {outside:?}");
    let mut failed = Vec::new();
    for (seed, result) in seeds.iter().zip(&results) {
        if let Err(why) = result {
            println!("         seed {seed} failed: {why}");
            failed.push(*seed);
        }
    }
    Figures { factor: factor[1], coverage, failed }
}

fn bar(claim: &str, holds: bool) -> bool {
    println!("{}: {claim}", if holds { "holds" } else { "MISSED" });
    holds
}
