//! Tuned robots over two decades of motor size: stable with kV and kA changed by 30 % each way, at 10.5 and 12.6 V?
//! `cargo xtask bench robustness [SEED [ROBOTS]]`; seed 1 and 60 robots by default. Of the robots of `bench tune`, the first ones.

use std::process::ExitCode;

use beeline_tests::parallel::in_order;
use beeline_tests::tuning::robots::draw;

fn main() -> ExitCode {
    let mut numbers = std::env::args().skip(1).map(|word| word.parse::<u64>());
    let (Ok(seed), Ok(robots)) =
        (numbers.next().unwrap_or(Ok(1)), numbers.next().unwrap_or(Ok(60)))
    else {
        eprintln!("usage: bench_robustness [SEED [ROBOTS]]");
        return ExitCode::from(2);
    };
    let numbers: Vec<u64> = (0..robots).map(|number| seed * 100_000 + number).collect();
    let results = in_order(&numbers, |number| {
        let robot = draw(*number);
        let outcome = robot.tune();
        outcome.tuned.ok().map(|_| (robot.meters_per_count(), robot.drive_changed(&outcome.config)))
    });
    let (mut tuned, mut stable, mut all_stable) = (0, 0, 0);
    for (number, result) in numbers.iter().zip(&results) {
        let Some((count_m, drives)) = result else { continue };
        tuned += 1;
        let unstable: Vec<_> = drives.iter().filter(|drive| !drive.is_stable(*count_m)).collect();
        stable += drives.len() - unstable.len();
        all_stable += usize::from(unstable.is_empty());
        for drive in unstable {
            println!("{number}, a count of {:.2} mm: {drive:?}", count_m * 1e3);
        }
    }
    println!(
        "{tuned} of {robots} robots were tuned; {all_stable} of them are stable with each change at each supply"
    );
    println!("{stable} of {} drives are stable", 8 * tuned);
    ExitCode::SUCCESS
}
