//! No file may contain what is true on one machine only.

use crate::{Outcome, root, tracked_files};

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
    let forbidden: Vec<(String, &str)> =
        FORBIDDEN.iter().map(|(pieces, why)| (pieces.concat(), *why)).collect();
    let files = tracked_files()?;
    let mut findings = Vec::new();
    for file in &files {
        let bytes =
            std::fs::read(root().join(file)).map_err(|e| format!("{}: {e}", file.display()))?;
        // A file that is not text has no words.
        let Ok(text) = String::from_utf8(bytes) else { continue };
        for (number, line) in text.lines().enumerate() {
            for (word, why) in forbidden.iter().filter(|(word, _)| line.contains(word.as_str())) {
                findings.push(format!("{}:{}: `{word}`: {why}", file.display(), number + 1));
            }
        }
    }
    println!("    {} files", files.len());
    if findings.is_empty() {
        Ok(())
    } else {
        Err(format!("take these out:\n{}", findings.join("\n")))
    }
}
