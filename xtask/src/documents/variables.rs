//! Variables of the environment in a page: what begins with our name is read somewhere in the sources.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::page::Page;

const OURS: &str = "BEELINE_";

/// Our variables in the sources.
pub fn known(base: &Path, files: &[PathBuf]) -> BTreeSet<String> {
    let is_source = |file: &&PathBuf| file.extension().is_some_and(|end| end == "rs");
    let texts = files.iter().filter(is_source).map(|file| std::fs::read_to_string(base.join(file)));
    texts.flatten().flat_map(|text| variables(&text)).collect()
}

/// Those of a page's code that are not among these, with their lines.
pub fn findings(known: &BTreeSet<String>, page: &Page) -> Vec<(usize, String)> {
    let mut findings = Vec::new();
    for piece in &page.code {
        let unknown = variables(&piece.text).into_iter().filter(|name| !known.contains(name));
        findings.extend(unknown.map(|name| (piece.line, format!("`{name}`: nothing reads it"))));
    }
    findings
}

fn variables(text: &str) -> Vec<String> {
    let words = text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    words.filter(|word| word.starts_with(OURS)).map(String::from).collect()
}
