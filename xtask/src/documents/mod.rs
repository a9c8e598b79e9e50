//! What the pages name exists: every `.md` file of the repository.
//!
//! - **Paths**: what in code begins with a folder of the root (`` `firmware/src/pid.rs` ``), or with a word that is nearly
//!   one, or is the bare name of a `.rs` or `.md` file; where links lead, from the page, with the heading behind `#`.
//! - **Chores**: `cargo xtask CHORE --flag` is in the help of `cargo xtask`, with the flag at this chore; so are cargo's
//!   own commands with their flags in a list, and the packages, tests, examples and programs that they name are there.
//! - **Variables** of the environment: something in the sources reads `BEELINE_PORT`.
//! - **Length**: the first page is to be read in a few minutes.
//!
//! What `beeline` understands (commands, flags, keys of the configuration and of files) is held by
//! `tests/binary/pages.rs`, which has the parser at hand: it needs the built command.

mod chores;
mod packages;
mod page;
mod paths;
mod variables;

use std::path::{Path, PathBuf};

use crate::repository::{root, tracked_files};
use crate::steps::Outcome;
use page::Page;

/// The first page has no more words than this.
const README_WORDS_MAX: usize = 1000;

pub fn check() -> Outcome {
    let files = tracked_files()?;
    let (findings, pages) = findings(root(), &files)?;
    println!(
        "    {pages} pages; the commands, flags and keys of `beeline` in them are checked by another test:"
    );
    println!("    cargo test -p host-cli --test binary pages");
    if findings.is_empty() { Ok(()) } else { Err(findings.join("\n")) }
}

/// What is wrong in the pages among these files, and how many pages there are.
fn findings(base: &Path, files: &[PathBuf]) -> Result<(Vec<String>, usize), String> {
    let is_page = |file: &&PathBuf| file.extension().is_some_and(|end| end == "md");
    let known = variables::known(base, files);
    let mut findings = Vec::new();
    let mut pages = 0;
    for file in files.iter().filter(is_page) {
        let name = file.display();
        let text =
            std::fs::read_to_string(base.join(file)).map_err(|error| format!("{name}: {error}"))?;
        let page = Page::read(&text);
        let mut found = paths::findings(base, files, file, &page);
        found.extend(chores::findings(base, files, &page));
        found.extend(variables::findings(&known, &page));
        findings.extend(found.iter().map(|(line, what)| format!("{name}:{line}: {what}")));
        let words = text.split_whitespace().count();
        if file == Path::new("README.md") && words > README_WORDS_MAX {
            findings.push(format!("{name}:1: {words} words, at most {README_WORDS_MAX}"));
        }
        pages += 1;
    }
    Ok((findings, pages))
}

#[cfg(test)]
mod tests;
