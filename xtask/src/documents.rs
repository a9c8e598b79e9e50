//! The paths that the documents name exist.
//!
//! A path is what stands in backquotes, or as the target of a link, and begins with the name of
//! something in the root: `` `firmware/src/pid.rs` ``, `` `docs/protocol.md` ``, `` `tests/` ``.

use std::collections::BTreeSet;

use crate::{Outcome, root};

const DOCUMENTS: [&str; 2] = ["ARCHITECTURE.md", "README.md"];

pub fn check() -> Outcome {
    let mut findings = Vec::new();
    for document in DOCUMENTS {
        let Ok(text) = std::fs::read_to_string(root().join(document)) else {
            findings.push(format!("{document}: is missing"));
            continue;
        };
        let paths = paths_in(&text);
        println!("    {document}: {} paths", paths.len());
        let missing = paths.iter().filter(|path| !root().join(path).exists());
        findings.extend(missing.map(|path| format!("{document}: `{path}` does not exist")));
    }
    if findings.is_empty() { Ok(()) } else { Err(findings.join("\n")) }
}

/// What in a text looks like a path in this repository.
fn paths_in(text: &str) -> BTreeSet<String> {
    // Odd pieces between backquotes are code; a fence's three make the count come out all the same.
    let code = text.lines().flat_map(|line| line.split('`').skip(1).step_by(2));
    let links = text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
    let looks_like_one = |path: &&str| {
        let first = path.split('/').next().unwrap_or_default();
        let is_ours = path.contains('/') || path.ends_with(".md");
        let plain = |c: char| c.is_ascii_alphanumeric() || "/._-".contains(c);
        is_ours && !path.starts_with('/') && path.chars().all(plain) && !first.is_empty()
    };
    // A path whose first part is no folder here is something else: `2/s`, `embedded-hal/1`.
    let known = |path: &&str| {
        let first = path.split('/').next().unwrap_or_default();
        path.ends_with(".md") || path.ends_with(".rs") || root().join(first).exists()
    };
    let found: BTreeSet<String> =
        code.filter(looks_like_one).filter(known).map(String::from).collect();
    // A link within the repository is a path whatever it looks like.
    let linked = links.filter(|link| !link.is_empty() && !link.contains(':')).map(String::from);
    found.into_iter().chain(linked).collect()
}

#[cfg(test)]
mod tests {
    use super::paths_in;

    #[test]
    fn paths_in_backquotes_and_links_are_found_and_other_words_are_not() {
        let text = "See `xtask/src/main.rs`, `gone/file.rs`, [the page](docs/page.md#part), \
                    [the web](https://example.org/a), `a/b`, `2 m/s`, `cargo run`, `NOTES.md`, \
                    [up](#there).";
        let found: Vec<String> = paths_in(text).into_iter().collect();
        assert_eq!(found, ["NOTES.md", "docs/page.md", "gone/file.rs", "xtask/src/main.rs"]);
    }
}
