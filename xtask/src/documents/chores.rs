//! Cargo's lines in a page: our chores with their flags, and cargo's own commands with theirs and what they name.

use std::path::{Path, PathBuf};

use super::packages::{Package, takes_name};
use super::page::Page;
use crate::help::HELP;

/// What builds something.
const BUILDING: &[&str] =
    &["bench", "build", "check", "clippy", "doc", "install", "run", "rustc", "test"];

/// What builds parts of a package that can be chosen.
const CHOOSING: &[&str] = &["bench", "build", "check", "clippy", "test"];

/// Cargo's flags that the pages may use, with the commands that take them. One that cargo has and that is missing here
/// is to be added when a page needs it.
const FLAGS: [(&[&str], &str); 13] = [
    (BUILDING, "--release -r --profile --features -F --all-features --no-default-features"),
    (BUILDING, "--target --target-dir --ignore-rust-version -j --jobs --bin --example"),
    (BUILDING, "-p --package --manifest-path"),
    (CHOOSING, "--workspace --exclude --all-targets"),
    (CHOOSING, "--lib --bins --examples --test --tests --bench --benches"),
    (&["clippy"], "--fix"),
    (&["doc"], "--workspace --exclude --no-deps --open"),
    (&["fmt"], "--all --check -p --package"),
    (&["install"], "--path --force --root"),
    (&["test"], "--doc --no-run --no-fail-fast"),
    (&["tree"], "-p --package --manifest-path --workspace --edges -e --invert -i --target"),
    (&["metadata"], "--manifest-path --no-deps --format-version"),
    (&["add", "clean", "deny", "update"], "-p --package"),
];

/// Flags of every command.
const OF_ALL: &str = "--color --config --frozen --help --locked --offline --quiet -q --verbose -v";

/// What is no chore, no flag, or names what is not there, with its line.
pub fn findings(base: &Path, files: &[PathBuf], page: &Page) -> Vec<(usize, String)> {
    let packages = Package::all(base, files);
    let mut findings = Vec::new();
    for piece in &page.code {
        let line = piece.text.split(" #").next().unwrap_or_default().trim();
        let line = line.strip_prefix("$ ").unwrap_or(line);
        for command in commands(line) {
            let problem = match &command[..] {
                ["cargo", "xtask", words @ ..] => problem_of_chore(base, files, words),
                ["cargo", command, words @ ..] => problem_of_cargo(&packages, command, words),
                _ => None,
            };
            findings.extend(problem.map(|problem| (piece.line, format!("`{line}`: {problem}"))));
        }
    }
    findings
}

/// The words of each command in a line, without variables in front. An optional word stands in brackets.
fn commands(line: &str) -> Vec<Vec<&str>> {
    let ends = |word: &&str| ["|", "||", "&&", ";", "&", ">", "2>", "\\"].contains(word);
    let is_variable = |word: &&&str| {
        word.split_once('=').is_some_and(|(name, _)| {
            name.chars().all(|c| c.is_ascii_uppercase() || c == '_') && !name.is_empty()
        })
    };
    let mut commands = Vec::new();
    for part in line.split(';') {
        let words: Vec<&str> = part.split_whitespace().collect();
        commands.extend(words.split(ends).map(|words| {
            let variables = words.iter().take_while(is_variable).count();
            words[variables..].iter().map(|word| word.trim_matches(['[', ']'])).collect()
        }));
    }
    commands
}

/// A word in capitals stands for one of the reader's.
fn is_placeholder(word: &str) -> bool {
    word.chars().all(|c| c.is_ascii_uppercase() || "_-.".contains(c))
}

/// The flags among words, without their values.
fn flags<'a>(words: &[&'a str]) -> impl Iterator<Item = &'a str> {
    words
        .iter()
        .filter(|word| word.starts_with('-'))
        .map(|word| word.split('=').next().unwrap_or(word))
}

/// The part of the help on each chore: its first line, and those below that are indented further.
fn chores() -> Vec<String> {
    let mut chores: Vec<String> = Vec::new();
    for line in HELP.lines().filter_map(|line| line.strip_prefix("  ")) {
        match chores.last_mut() {
            Some(chore) if line.starts_with(' ') => *chore += line,
            _ => chores.push(line.to_owned()),
        }
    }
    chores
}

/// The flags that the help has in brackets.
fn flags_in(help: &str) -> Vec<&str> {
    let inner = help.split('[').skip(1).filter_map(|text| text.split([' ', ']']).next());
    inner.filter(|word| word.starts_with("--")).collect()
}

fn problem_of_chore(base: &Path, files: &[PathBuf], words: &[&str]) -> Option<String> {
    let (chore, rest) = words.split_first()?;
    let chores = chores();
    let is_named = |help: &&String, names: &[&str]| {
        help.split_whitespace().zip(names).filter(|(word, name)| word == *name).count()
            == names.len()
    };
    let Some(help) = chores.iter().find(|help| is_named(help, &[chore])) else {
        return Some(format!("there is no chore `{chore}`"));
    };
    let unknown = |known: &[&str]| flags(rest).find(|flag| !known.contains(flag));
    if *chore != "bench" {
        let flag = unknown(&flags_in(help))?;
        return Some(format!("`{chore}` has no flag `{flag}`"));
    }
    let name = rest.first().filter(|name| !is_placeholder(name) && !name.starts_with('-'))?;
    let takes_no = |flag| format!("`bench {name}` has no flag `{flag}`");
    if let Some(help) = chores.iter().find(|help| is_named(help, &["bench", name])) {
        return unknown(&flags_in(help)).map(takes_no);
    }
    if *name == "all" {
        return unknown(&[]).map(takes_no);
    }
    let file = PathBuf::from(format!("tests/examples/bench_{name}"));
    let sources: Vec<&PathBuf> = files
        .iter()
        .filter(|path| path.starts_with(&file) || **path == file.with_extension("rs"))
        .collect();
    if sources.is_empty() {
        return Some(format!("there is no bench `{name}`"));
    }
    // A bench reads its own flags.
    let text = sources.iter().filter_map(|path| std::fs::read_to_string(base.join(path)).ok());
    let text: String = text.collect();
    flags(rest).find(|flag| !text.contains(&format!("\"{flag}\""))).map(takes_no)
}

fn problem_of_cargo(packages: &[Package], command: &str, words: &[&str]) -> Option<String> {
    let lists = FLAGS.iter().filter(|(commands, _)| commands.contains(&command));
    let mut known: Vec<&str> = lists.flat_map(|(_, list)| list.split(' ')).collect();
    if known.is_empty() {
        let is_command = !command.starts_with(['-', '+']) && !is_placeholder(command);
        return is_command.then(|| format!("cargo has no command `{command}`"));
    }
    known.extend(OF_ALL.split(' '));
    // What stands behind `--` is for the program.
    let words: Vec<&str> = words.iter().copied().take_while(|word| *word != "--").collect();
    if let Some(flag) = flags(&words).find(|flag| !known.contains(flag)) {
        return Some(format!("`cargo {command}` has no flag `{flag}`"));
    }
    problem_of_names(packages, &words)
}

/// The names behind options, be it `--test name`, `--test=name` or `--features one,two`.
fn named<'a>(words: &[&'a str]) -> Vec<(&'a str, &'a str)> {
    let apart = words.windows(2).map(|pair| (pair[0], pair[1]));
    let joined = words.iter().filter_map(|word| word.split_once('='));
    let pairs = apart.chain(joined);
    let each = pairs.flat_map(|(option, names)| names.split(',').map(move |name| (option, name)));
    each.filter(|(_, name)| !is_placeholder(name)).collect()
}

fn problem_of_names(packages: &[Package], words: &[&str]) -> Option<String> {
    let named = named(words);
    let is_of_package = |option: &str| ["-p", "--package"].contains(&option);
    let chosen: Vec<&str> =
        named.iter().filter(|(option, _)| is_of_package(option)).map(|(_, name)| *name).collect();
    if let Some(name) = chosen.iter().find(|name| packages.iter().all(|one| one.name != **name)) {
        return Some(format!("there is no package `{name}`"));
    }
    let is_searched = |one: &&Package| chosen.is_empty() || chosen.contains(&one.name.as_str());
    let is_there = |option: &str, name: &str| {
        packages.iter().filter(is_searched).any(|one| one.has(option, name))
    };
    let (option, name) =
        named.iter().find(|(option, name)| takes_name(option) && !is_there(option, name))?;
    let of = if chosen.is_empty() { String::new() } else { format!(" of {}", chosen.join(", ")) };
    Some(format!("there is no `{name}` for `{option}`{of}"))
}
