//! The project's own chores: `cargo xtask help`.

mod arrows;
mod bench;
mod boards;
mod browser;
mod circles;
mod dependencies;
mod documents;
mod emulated;
#[cfg(test)]
mod example_repository;
mod firmware;
mod forbidden_words;
mod fuzz;
mod help;
mod lengths;
mod peers;
mod prerequisites;
mod repository;
mod side_effects;
mod source;
mod steps;
mod test;
mod test_binaries;
mod third_party;
mod wheel;

use std::process::ExitCode;

use help::HELP;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let outcome = match args[..] {
        ["test"] => test::run(),
        ["dependencies"] => dependencies::check(),
        ["third-party"] => third_party::run(),
        ["arrows"] => arrows::run(),
        ["peers"] => peers::check(),
        ["wheel"] => wheel::test(),
        ["boards"] => boards::write(),
        ["check"] => test::check(),
        ["firmware", ref args @ ..] => firmware::run(args),
        ["fuzz", ref args @ ..] => fuzz::run(args),
        ["emulate", ref args @ ..] => emulated::serve(args),
        ["bench", "firmware"] => emulated::bench(),
        ["bench", "faults", ref args @ ..] => emulated::bench_faults(args),
        ["bench", "dead-hosts", ref args @ ..] => emulated::bench_dead_hosts(args),
        ["bench", "crash"] => bench::crash(),
        ["bench", "pages"] => browser::bench(),
        ["bench", name, ref args @ ..] => bench::run(name, args),
        ["bench"] => Err(bench::listing("which one?")),
        ["help" | "--help" | "-h"] | [] => {
            print!("{HELP}");
            Ok(())
        }
        [chore, ..] => {
            Err(format!("no chore `{}`\n\n{HELP}", [&[chore], &args[1..]].concat().join(" ")))
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}
