//! `cargo xtask bench NAME`: runs `tests/examples/bench_NAME.rs`.

use crate::repository::root;
use crate::steps::{Outcome, cargo};

/// Runs one bench with its arguments, or all of them.
pub fn run(name: &str, args: &[&str]) -> Outcome {
    let known = names();
    let chosen: Vec<&str> = match name {
        "all" => known.iter().map(String::as_str).collect(),
        name if known.iter().any(|known| known == name) => vec![name],
        "firmware" | "crash" | "pages" => return Err(format!("`bench {name}` takes no arguments")),
        name => return Err(listing(&format!("no bench `{name}`"))),
    };
    chosen.into_iter().try_for_each(|name| {
        let example = format!("bench_{name}");
        let line = ["run", "--release", "-p", "beeline-tests", "--example", &example, "--"];
        cargo(&[&line, args].concat(), &[], "the bench itself says what is wrong, above")
    })
}

/// Ends every command that writes at every point: a test, as it needs the executable, that is ignored unless asked for.
pub fn crash() -> Outcome {
    let test = "every_writing_command_ended_at_every_point";
    let line = ["test", "--release", "-p", "host-cli", "--test", "binary", test, "--"];
    let output = ["--ignored", "--nocapture"];
    cargo(&[line.as_slice(), &output].concat(), &[], "each point that is wrong is named above")
}

/// The benches there are, after a message.
pub fn listing(message: &str) -> String {
    let mut names = names();
    names.extend(["firmware", "faults", "dead-hosts", "crash", "pages", "all"].map(String::from));
    format!("{message}\n       benches: {}", names.join(", "))
}

fn names() -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(root().join("tests/examples")) else { return Vec::new() };
    let mut names: Vec<String> = entries
        .flatten()
        .filter_map(|entry| {
            let file = entry.file_name().into_string().ok()?;
            // An example is a file or a folder.
            Some(file.strip_prefix("bench_")?.trim_end_matches(".rs").to_string())
        })
        .collect();
    names.sort();
    names
}
