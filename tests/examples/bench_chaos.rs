//! Thousands of sessions in a storm, each held to the same invariants: `cargo xtask bench chaos --seed S --sessions N`.

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::time::Instant;

use beeline_tests::chaos::{Invariant, SESSIONS_EACH, robots, run_robot};
use beeline_tests::parallel::in_order;
use clap::Parser;

/// Everything fails at once, and what must hold is looked at all the time.
#[derive(Parser)]
struct Args {
    /// Draws everything.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many sessions, ten to a robot.
    #[arg(long, default_value_t = 1000)]
    sessions: u32,
    /// One robot alone, by its own seed, as a failure names it.
    #[arg(long)]
    robot: Option<u64>,
}

fn main() -> ExitCode {
    let args = Args::parse();
    println!("seed {}, {} sessions", args.seed, args.sessions);
    let robots = args.robot.map_or_else(|| robots(args.seed, args.sessions), |robot| vec![robot]);
    let begun = Instant::now();
    let outcomes = in_order(&robots, |robot| run_robot(*robot, SESSIONS_EACH, None));
    let mut broken: BTreeMap<Invariant, u32> = BTreeMap::new();
    let (mut virtual_s, mut fingerprint) = (0.0, 0_u64);
    let mut totals = BTreeMap::new();
    for (robot, outcome) in robots.iter().zip(&outcomes) {
        for (session, found) in &outcome.broken {
            *broken.entry(found.invariant).or_default() += 1;
            println!("--robot {robot}, session {session}: {found}");
        }
        virtual_s += outcome.virtual_us as f64 * 1e-6;
        fingerprint = fingerprint.rotate_left(9) ^ outcome.fingerprint;
        for (name, count) in outcome.done.named() {
            *totals.entry(name).or_insert(0) += count;
        }
    }
    let sessions = robots.len() as u32 * SESSIONS_EACH;
    let took_s = begun.elapsed().as_secs_f64();
    println!("{sessions} sessions, {virtual_s:.0} s of the robots' time in {took_s:.1} s");
    println!("done: {totals:?}; fingerprint {fingerprint:016x}");
    for invariant in Invariant::ALL {
        println!(
            "{:<24} broken {}",
            format!("{invariant:?}"),
            broken.get(&invariant).unwrap_or(&0)
        );
    }
    if broken.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
