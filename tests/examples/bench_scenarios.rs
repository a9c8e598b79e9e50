//! The shipped scenarios: is the cause of each named, and is nothing saved that makes the next straight worse?
//! `cargo xtask bench scenarios [--seeds N] [--only NAME] [--skip-explain] [--skip-saving]`.

use std::process::ExitCode;

use beeline_tests::parallel::in_order;
use beeline_tests::scenarios::cause::explained;
use beeline_tests::scenarios::saving::{Procedure, Saved, saved_by};
use beeline_tests::scenarios::{names, shipped};

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let value = |key: &str| words.iter().position(|w| w == key).and_then(|i| words.get(i + 1));
    let seeds: u64 = value("--seeds").map_or(10, |n| n.parse().expect("a number"));
    let only = value("--only");
    let has = |key: &str| words.iter().any(|word| word == key);
    for name in names().iter().filter(|name| only.is_none_or(|only| *only == **name)) {
        println!("== {name}");
        let seeds: Vec<u64> = (1..=seeds).collect();
        if !has("--skip-explain") {
            let answers = in_order(&seeds, |seed| explained(&shipped(name, *seed)));
            for (seed, answer) in seeds.iter().zip(answers) {
                match answer {
                    Err(why) => println!("{seed:>3} explain  {why}"),
                    Ok(answer) => {
                        let steps: Vec<String> = answer
                            .steps
                            .iter()
                            .map(|step| {
                                format!(
                                    "{}{} {:.2}",
                                    if step.matters { "" } else { "~" },
                                    step.class.join("|"),
                                    step.effect_size_m * 1e3
                                )
                            })
                            .collect();
                        println!(
                            "{seed:>3} explain  {} [{:.1} mm, structure {}]",
                            steps.join(", "),
                            answer.baseline.cross_validated.position_rms_m * 1e3,
                            answer.unexplained.structure
                        );
                    }
                }
            }
        }
        if has("--skip-saving") {
            continue;
        }
        for procedure in Procedure::ALL {
            let done = in_order(&seeds, |seed| saved_by(&shipped(name, *seed), procedure));
            let mut worse = 0;
            for (seed, result) in seeds.iter().zip(&done) {
                match result {
                    Err(why) => println!("{seed:>3} {:<22} {why}", procedure.name()),
                    Ok(Saved { decision, saved, wheel_weight, before_m, after_m }) => {
                        worse += usize::from(result.as_ref().is_ok_and(Saved::is_worse));
                        println!(
                            "{seed:>3} {:<22} {decision:<28} {} W_T {wheel_weight:.6} {:>6.2} -> {:>6.2} mm{}",
                            procedure.name(),
                            if *saved { "saved" } else { "     " },
                            before_m * 1e3,
                            after_m * 1e3,
                            if result.as_ref().is_ok_and(Saved::is_worse) { "  WORSE" } else { "" }
                        );
                    }
                }
            }
            println!("    {:<22} worse: {worse}", procedure.name());
        }
    }
    ExitCode::SUCCESS
}
