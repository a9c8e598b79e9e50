//! Records a robot with a hidden effect for a reader to find, or opens the answer:
//!
//! ```text
//! cargo run --release -p beeline-tests --example mystery -- record FOLDER [SEED]
//! cargo run --release -p beeline-tests --example mystery -- open [FOLDER]        prints what is hidden
//! ```

use std::path::Path;
use std::process::ExitCode;

use beeline_tests::blind::mystery::{Mystery, read_sealed, seal};
use beeline_tests::blind::sim_target_robot::keep;

const USUAL: &str = "examples/mystery-robot";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let outcome = match words[..] {
        ["record", folder] => record(Path::new(folder), None),
        ["record", folder, seed] => match seed.parse() {
            Ok(seed) => record(Path::new(folder), Some(seed)),
            Err(_) => Err(format!("{seed} is not a seed")),
        },
        ["open"] => open(Path::new(USUAL)),
        ["open", folder] => open(Path::new(folder)),
        _ => Err("usage: mystery record FOLDER [SEED] | open [FOLDER]".to_owned()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

/// Without a seed, one is drawn from the clock.
fn record(folder: &Path, seed: Option<u64>) -> Result<(), String> {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let seed = seed.unwrap_or_else(|| now.map_or(0, |since| u64::from(since.subsec_nanos())));
    let mystery = Mystery::draw(seed);
    let campaign = mystery.campaign().map_err(|error| error.to_string())?;
    keep(&campaign, folder).map_err(|error| error.to_string())?;
    std::fs::write(folder.join("answer.toml.sealed"), mystery.sealed())
        .map_err(|error| error.to_string())?;
    eprintln!("{}: {} runs; what is hidden is sealed", folder.display(), campaign.runs.len());
    Ok(())
}

fn open(folder: &Path) -> Result<(), String> {
    let file = folder.join("answer.toml.sealed");
    let text =
        std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    let (seed, sha256) = read_sealed(&text).map_err(|why| format!("{}: {why}", file.display()))?;
    let answer = Mystery::draw(seed).answer();
    print!("{answer}");
    if seal(&answer) == sha256 {
        eprintln!("the seal holds: SHA-256 {sha256}");
        Ok(())
    } else {
        Err(format!("the seal is broken: {} is not {sha256}", seal(&answer)))
    }
}
