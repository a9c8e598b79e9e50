//! Paths and links of a page.

use std::path::{Path, PathBuf};

use super::page::Page;

/// What does not exist, with its line.
pub fn findings(base: &Path, files: &[PathBuf], file: &Path, page: &Page) -> Vec<(usize, String)> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let mut findings = Vec::new();
    for piece in &page.code {
        for path in paths_in(base, &piece.text) {
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
fn paths_in<'a>(base: &Path, code: &'a str) -> Vec<&'a str> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-".contains(c);
    let words = code.split(|c: char| c.is_whitespace() || "\"'=:,;()".contains(c));
    let words = words.filter(|word| !word.is_empty() && word.chars().all(plain));
    let is_ours = |word: &&str| {
        let Some((first, _)) = word.split_once('/') else {
            return word.ends_with(".rs") || word.ends_with(".md");
        };
        // One whose first part is no folder here is something else: `2/s`, `embedded-hal/1`; `..`
        // leads to the folder of another program.
        let is_source = word.ends_with(".rs") || word.ends_with(".md");
        !["", ".", ".."].contains(&first) && (is_source || base.join(first).is_dir())
    };
    words.filter(is_ours).collect()
}
