//! Cargo's lines in a page.

use std::path::{Path, PathBuf};

use super::page::Page;
use crate::help::HELP;

/// What is no chore, or names what is not there, with its line.
pub fn findings(base: &Path, files: &[PathBuf], page: &Page) -> Vec<(usize, String)> {
    let mut findings = Vec::new();
    for piece in &page.code {
        let line = piece.text.split(" #").next().unwrap_or_default().trim();
        let line = line.strip_prefix("$ ").unwrap_or(line);
        let words: Vec<&str> = line.split_whitespace().collect();
        let problem = match words[..] {
            ["cargo", "xtask", ref words @ ..] => problem_of_chore(base, files, words),
            ["cargo", ref words @ ..] => problem_of_names(base, files, words),
            _ => None,
        };
        findings.extend(problem.map(|problem| (piece.line, format!("`{line}`: {problem}"))));
    }
    findings
}

/// The chores, each with its line of the help.
fn chores() -> impl Iterator<Item = &'static str> {
    HELP.lines().filter_map(|line| line.strip_prefix("  ").filter(|line| !line.starts_with(' ')))
}

fn problem_of_chore(base: &Path, files: &[PathBuf], words: &[&str]) -> Option<String> {
    let (chore, rest) = words.split_first()?;
    if !chores().any(|line| line.split_whitespace().next() == Some(chore)) {
        return Some(format!("there is no chore `{chore}`"));
    }
    let flags = rest.iter().filter(|word| word.starts_with("--"));
    if *chore != "bench" {
        let is_in_help = |flag: &&&str| {
            HELP.split(|c: char| c != '-' && !c.is_ascii_lowercase()).any(|word| word == **flag)
        };
        let mut unknown = flags.filter(|flag| !is_in_help(flag));
        return unknown.next().map(|flag| format!("there is no flag `{flag}`"));
    }
    let name = rest.first().filter(|name| name.chars().all(|c| c.is_ascii_lowercase()))?;
    if !["firmware", "faults", "crash", "all"].contains(name)
        && !has_example(files, &format!("bench_{name}"))
    {
        return Some(format!("there is no bench `{name}`"));
    }
    // A bench reads its own flags.
    let benches: Vec<String> = files
        .iter()
        .filter(|file| {
            file.starts_with("tests/examples")
                || file.ends_with("emulated-board/examples/faults.rs")
        })
        .filter_map(|file| std::fs::read_to_string(base.join(file)).ok())
        .collect();
    // By its text, or as a field of its arguments.
    let is_known = |flag: &&&str| {
        let field = format!("\n    {}: ", flag.trim_start_matches('-').replace('-', "_"));
        benches.iter().any(|text| text.contains(&format!("\"{flag}\"")) || text.contains(&field))
    };
    let mut unknown = flags.filter(|flag| !is_known(flag));
    unknown.next().map(|flag| format!("no bench has a flag `{flag}`"))
}

fn problem_of_names(base: &Path, files: &[PathBuf], words: &[&str]) -> Option<String> {
    words.windows(2).find_map(|pair| {
        let [option, name] = pair else { return None };
        let is_there = match *option {
            "--example" => has_example(files, name),
            "-p" | "--package" => has_package(base, files, name),
            _ => true,
        };
        (!is_there).then(|| format!("there is no `{name}`"))
    })
}

/// An example is a file or a folder.
fn has_example(files: &[PathBuf], name: &str) -> bool {
    let (file, folder) = (format!("examples/{name}.rs"), format!("examples/{name}/main.rs"));
    files.iter().any(|path| path.ends_with(&file) || path.ends_with(&folder))
}

fn has_package(base: &Path, files: &[PathBuf], name: &str) -> bool {
    let line = format!("name = \"{name}\"");
    files.iter().filter(|file| file.ends_with("Cargo.toml")).any(|file| {
        std::fs::read_to_string(base.join(file))
            .is_ok_and(|text| text.lines().any(|other| other == line))
    })
}
