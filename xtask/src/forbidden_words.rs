//! No file may contain what is true on one machine only.

use crate::repository::{root, tracked_files};
use crate::steps::Outcome;

/// A forbidden word, in pieces so that this file does not contain it, and why it is forbidden.
const FORBIDDEN: &[(&[&str], &str)] = &[
    (&["/wo", "rk/"], "a path of one machine"),
    (&["/ro", "ot/"], "a path of one machine"),
    (&["/ho", "me/"], "a path of one machine"),
    (&["/tmp/", "target"], "a build folder of one machine"),
    (&["index.", "crates.io"], "the compiler's settings say where packages come from"),
    (&["static.", "crates.io"], "the compiler's settings say where packages come from"),
];

pub fn check() -> Outcome {
    let files = tracked_files()?;
    let mut findings = Vec::new();
    for file in &files {
        let name = file.display().to_string();
        let bytes = std::fs::read(root().join(file)).map_err(|e| format!("{name}: {e}"))?;
        // A file that is not text has no words.
        if let Ok(text) = String::from_utf8(bytes) {
            findings.extend(findings_in(&name, &text));
        }
    }
    println!("    {} files", files.len());
    if findings.is_empty() {
        Ok(())
    } else {
        Err(format!("take these out:\n{}", findings.join("\n")))
    }
}

/// `file:line: word: why`, for each forbidden word in a text.
fn findings_in(file: &str, text: &str) -> Vec<String> {
    let mut findings = Vec::new();
    for (pieces, why) in FORBIDDEN {
        let word = pieces.concat();
        for (number, _) in text.lines().enumerate().filter(|(_, line)| line.contains(&word)) {
            findings.push(format!("{file}:{}: `{word}`: {why}", number + 1));
        }
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::{FORBIDDEN, findings_in};

    #[test]
    fn every_forbidden_word_is_found_in_its_line() {
        for (pieces, why) in FORBIDDEN {
            let word = pieces.concat();
            let found = findings_in("page.md", &format!("good\nsee {word}there\ngood"));
            assert_eq!(found, [format!("page.md:2: `{word}`: {why}")]);
        }
    }

    #[test]
    fn ordinary_words_are_not_found() {
        let text = "target/release, crates.io, the root, /tmp/picture.svg, at work";
        assert!(findings_in("page.md", text).is_empty());
    }
}
