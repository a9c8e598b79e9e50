//! Paths and links of a page.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::page::Page;

/// What does not exist, with its line.
pub fn findings(base: &Path, files: &[PathBuf], file: &Path, page: &Page) -> Vec<(usize, String)> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let mut findings = Vec::new();
    let in_folders = files.iter().filter(|file| file.components().count() > 1);
    let folders: BTreeSet<&str> =
        in_folders.filter_map(|file| file.iter().next()?.to_str()).collect();
    for piece in &page.code {
        for path in paths_in(base, &folders, &piece.text) {
            let is_there = base.join(path).exists()
                || base.join(folder).join(path).exists()
                || !path.contains('/') && files.iter().any(|file| file.ends_with(path));
            if !is_there {
                findings.push((piece.line, format!("`{path}` does not exist")));
            }
        }
    }
    for link in page.links.iter().filter(|link| !link.text.contains(':')) {
        let (path, anchor) = link.text.split_once('#').unwrap_or((&link.text, ""));
        let target = if path.is_empty() { base.join(file) } else { base.join(folder).join(path) };
        if !target.exists() {
            findings.push((link.line, format!("the link to `{path}` leads nowhere")));
        } else if !anchor.is_empty() && !has_anchor(&target, anchor) {
            findings.push((link.line, format!("`{}` has no such heading", link.text)));
        }
    }
    findings
}

fn has_anchor(page: &Path, anchor: &str) -> bool {
    std::fs::read_to_string(page).is_ok_and(|text| Page::read(&text).anchors.contains(anchor))
}

/// What in code looks like a path in this repository.
fn paths_in<'a>(base: &Path, folders: &BTreeSet<&str>, code: &'a str) -> Vec<&'a str> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-".contains(c);
    let words = code.split(|c: char| c.is_whitespace() || "\"'=:,;()".contains(c));
    let words = words.filter(|word| !word.is_empty() && word.chars().all(plain));
    let is_ours = |word: &&str| {
        let Some((first, _)) = word.split_once('/') else {
            return word.ends_with(".rs") || word.ends_with(".md");
        };
        // One whose first part is no folder here, nor nearly one, is something else: `2/s`, `embedded-hal/1`;
        // `..` leads to the folder of another program.
        let is_source = word.ends_with(".rs") || word.ends_with(".md");
        let is_folder = || base.join(first).is_dir();
        let is_misspelt = || folders.iter().any(|folder| is_near(first, folder));
        !["", ".", ".."].contains(&first) && (is_source || is_folder() || is_misspelt())
    };
    words.filter(is_ours).collect()
}

/// Whether a word is a name with a slip or two; in a short name, two make another word.
fn is_near(word: &str, name: &str) -> bool {
    let slips_max = if name.len() < 7 { 1 } else { 2 };
    (1..=slips_max).contains(&distance(word, name))
}

/// How many letters are to be added, left out or changed, or neighbours exchanged, to make one word of the other.
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![(0..=b.len()).collect::<Vec<usize>>()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let above = &rows[i - 1];
            let changed = above[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = changed.min(above[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(rows[i - 2][j - 2] + 1);
            }
            row.push(least);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}
