//! `cargo xtask bench dead-hosts [--seed S] [--cases N]`: hosts that die while the robot drives, with 0 to 16 MB of theirs
//! held back on the way, and stops under flood, on the flashed image.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use emulated_board::dead_host::{Found, run};

const USE: &str = "use: cargo xtask bench dead-hosts [--seed S] [--cases N]";

/// Cases on one board, from power-on.
const EACH: u32 = 20;

fn main() -> ExitCode {
    let (mut seed, mut cases) = (1_u64, 1000);
    let mut args = std::env::args().skip(1);
    while let Some(option) = args.next() {
        let number = args.next().and_then(|text| text.parse().ok());
        match (option.as_str(), number) {
            ("--seed", Some(number)) => seed = number,
            ("--cases", Some(number)) => cases = number as u32,
            _ => return complain(USE),
        }
    }
    let Some(image) = std::env::var_os("BEELINE_IMAGE").map(PathBuf::from) else {
        return complain("run this by `cargo xtask bench dead-hosts`");
    };
    println!("seed {seed}, {cases} cases");
    let begun = Instant::now();
    let mut latest: BTreeMap<String, (u32, u64)> = BTreeMap::new();
    let mut wrong = 0;
    for board in 0..cases.div_ceil(EACH) {
        let board_seed = seed.wrapping_mul(1_000_003).wrapping_add(u64::from(board));
        let found = match run(&image, board_seed, EACH) {
            Ok(found) => found,
            Err(error) => return complain(&format!("board {board}: {error}")),
        };
        let worst_us = found.iter().map(|found| found.after_us).max().unwrap_or(0);
        eprintln!("board {board}: after {:.1} ms at the latest", worst_us as f64 * 1e-3);
        for (number, found) in found.iter().enumerate() {
            let Found { held, after_us, .. } = found;
            let (count, latest_us) = latest.entry(format!("{held:?}")).or_default();
            *count += 1;
            *latest_us = (*latest_us).max(*after_us);
            if !found.holds() {
                wrong += 1;
                println!("board {board}, case {number}: {found:?}");
            }
        }
    }
    for (held, (count, latest_us)) in latest {
        println!(
            "{held:<22} {count:>5} cases, after {:.1} ms at the latest",
            latest_us as f64 * 1e-3
        );
    }
    println!("{wrong} wrong, in {:.0} s", begun.elapsed().as_secs_f64());
    if wrong == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn complain(why: &str) -> ExitCode {
    eprintln!("{why}");
    ExitCode::from(2)
}
