//! Thousands of sessions in which everything breaks: `cargo xtask bench chaos --seed S --sessions N`.
//!
//! Each failure prints the command that repeats it alone. `--plant FAULT` plants a fault first, to see that it is found.

use std::process::ExitCode;
use std::time::Instant;

use beeline_tests::chaos::{Ends, Plant, session};
use beeline_tests::parallel::in_order;
use clap::Parser;

/// Whole sessions of hosts, server, line and robot, in which everything breaks.
#[derive(Parser)]
struct Args {
    /// Draws everything.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many sessions.
    #[arg(long, default_value_t = 1000)]
    sessions: u64,
    /// Only this one.
    #[arg(long)]
    session: Option<u64>,
    /// A fault to plant: no-late-check, no-session-check, no-latch.
    #[arg(long, value_parser = plant)]
    plant: Option<Plant>,
}

fn plant(name: &str) -> Result<Plant, String> {
    let found = Plant::ALL.into_iter().find(|(known, _)| *known == name);
    found.map(|(_, plant)| plant).ok_or_else(|| "there is no such fault to plant".into())
}

fn main() -> ExitCode {
    let args = Args::parse();
    let plant = args.plant.unwrap_or_default();
    let numbers: Vec<u64> = args.session.map_or((0..args.sessions).collect(), |one| vec![one]);
    println!("seed {}, {} sessions", args.seed, numbers.len());
    let start = Instant::now();
    // Panics are told with their session.
    std::panic::set_hook(Box::new(|_| ()));
    let ends = in_order(&numbers, |number| session(args.seed, *number, plant));
    let mut sum = Ends::default();
    let mut failures = 0;
    for (number, end) in numbers.iter().zip(&ends) {
        match end {
            Ok(end) => {
                sum.well += end.well;
                sum.error += end.error;
                sum.killed += end.killed;
            }
            Err(what) => {
                failures += 1;
                println!("session {number}: {what}");
                println!("  cargo xtask bench chaos --seed {} --session {number}", args.seed);
            }
        }
    }
    println!(
        "{failures} failures; procedures: {} ended well, {} with one clear error, {} were killed; {:.0} s",
        sum.well,
        sum.error,
        sum.killed,
        start.elapsed().as_secs_f64()
    );
    if failures == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
