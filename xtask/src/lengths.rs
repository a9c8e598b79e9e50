//! No file of more than 400 lines without a reason in its head, and no function of more than 70.
//!
//! The reason is a line of the file's documentation: `//! Longer than 400 lines because ...`. A function is counted from
//! its `fn` to its closing brace, with signature and comments; clippy's count leaves both out. The files are formatted by
//! rustfmt, so the closing brace stands below the `fn`.

use crate::repository::{root, tracked_files};
use crate::steps::Outcome;

const LINES_MAX: usize = 400;
const FUNCTION_LINES_MAX: usize = 70;
const REASON: &str = "//! Longer than 400 lines because ";

pub fn check() -> Outcome {
    let mut findings = Vec::new();
    let files = tracked_files()?;
    for file in files.iter().filter(|file| file.extension().is_some_and(|end| end == "rs")) {
        let name = file.display();
        let text = std::fs::read_to_string(root().join(file))
            .map_err(|error| format!("{name}: {error}"))?;
        if is_too_long(&text) {
            findings.push(format!("{name}: {} lines", text.lines().count()));
        }
        for (line, length) in long_functions(&text) {
            findings.push(format!("{name}:{line}: a function of {length} lines"));
        }
    }
    if findings.is_empty() {
        return Ok(());
    }
    let advice = format!("split these, or say of a file why not: `{REASON}...` in its head");
    Err(format!("{advice}\n{}", findings.join("\n")))
}

fn is_too_long(text: &str) -> bool {
    let mut head = text.lines().take_while(|line| line.starts_with("//"));
    text.lines().count() > LINES_MAX && !head.any(|line| line.starts_with(REASON))
}

/// Functions that are too long: the line that each begins at, and how many it has.
fn long_functions(text: &str) -> Vec<(usize, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let begins = lines.iter().enumerate().filter(|(_, line)| is_function(line));
    let with_length = begins.map(|(at, line)| {
        let indent = line.len() - line.trim_start().len();
        // A declaration without a body ends at this depth with a semicolon.
        let is_end = |line: &&str| {
            let (depth, rest) = line.split_at_checked(indent).unwrap_or((line, ""));
            depth.trim().is_empty()
                && (rest.starts_with('}') || rest.starts_with(')') && rest.ends_with(';'))
        };
        let one_line = line.ends_with('}') || line.ends_with(';');
        let more = lines[at + 1..].iter().position(is_end).map_or(0, |after| after + 1);
        (at + 1, if one_line { 1 } else { more + 1 })
    });
    with_length.filter(|(_, length)| *length > FUNCTION_LINES_MAX).collect()
}

fn is_function(line: &str) -> bool {
    let mut words = line.split_whitespace().skip_while(|word| {
        // `pub(in crate::a)` is two words.
        word.starts_with("pub")
            || word.ends_with(')')
            || matches!(*word, "const" | "async" | "unsafe" | "extern" | "\"C\"")
    });
    words.next() == Some("fn")
}

#[cfg(test)]
mod tests {
    use super::{REASON, is_too_long, long_functions};

    #[test]
    fn a_function_is_counted_with_its_signature_and_comments() {
        let long = |body: usize| {
            let body = "        // Counted.\n".repeat(body);
            format!(
                "impl X {{\n    pub(super) async fn f(\n        &self,\n    ) -> u8 {{\n{body}    }}\n}}\n"
            )
        };
        assert_eq!(long_functions(&long(66)), []);
        assert_eq!(long_functions(&long(67)), [(2, 71)]);
        let declared = "    fn f(\n        &self,\n    ) -> u8;\n";
        assert_eq!(long_functions(&format!("{declared}{}", "    // A comment.\n".repeat(80))), []);
    }

    #[test]
    fn a_long_file_needs_a_reason_in_its_head() {
        let lines = "let x = 1;\n".repeat(400);
        assert!(!is_too_long(&lines));
        assert!(is_too_long(&format!("{lines}let y = 2;\n")));
        assert!(!is_too_long(&format!("//! A table.\n//!\n{REASON}it is one table.\n{lines}")));
        assert!(is_too_long(&format!("{lines}{REASON}it is one table.\n")));
    }
}
