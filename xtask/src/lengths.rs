//! No file of more than 400 lines without a reason in its head.
//!
//! The reason is a line of the file's documentation: `//! Longer than 400 lines because ...`. That no
//! function has more than 70 lines is held by clippy (`clippy.toml`).

use crate::{Outcome, root, tracked_files};

const LINES_MAX: usize = 400;
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
    }
    if findings.is_empty() {
        return Ok(());
    }
    let advice = format!("split these, or say why not: `{REASON}...` in the file's head");
    Err(format!("{advice}\n{}", findings.join("\n")))
}

fn is_too_long(text: &str) -> bool {
    let mut head = text.lines().take_while(|line| line.starts_with("//"));
    text.lines().count() > LINES_MAX && !head.any(|line| line.starts_with(REASON))
}

#[cfg(test)]
mod tests {
    use super::{REASON, is_too_long};

    #[test]
    fn a_long_file_needs_a_reason_in_its_head() {
        let lines = "let x = 1;\n".repeat(400);
        assert!(!is_too_long(&lines));
        assert!(is_too_long(&format!("{lines}let y = 2;\n")));
        assert!(!is_too_long(&format!("//! A table.\n//!\n{REASON}it is one table.\n{lines}")));
        assert!(is_too_long(&format!("{lines}{REASON}it is one table.\n")));
    }
}
