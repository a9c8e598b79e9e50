//! Text from outside, made safe for where it goes: a terminal, a page, a shell.
//!
//! Names, cells and keys come from files of others and from the robot. Every line that is printed goes through `terminal`,
//! every text in a page through `html`, every word of a suggested command through `shell`. Nothing else need know where a
//! text is from.

use std::fmt::Write as _;
use std::hash::{BuildHasher, Hasher, RandomState};
use std::sync::LazyLock;

/// Noncharacters, which Unicode reserves for a program's own use: they mark where a style begins, until the line is printed.
const STYLE_MARKS: std::ops::RangeInclusive<char> = '\u{fdd0}'..='\u{fdef}';

/// What follows a mark that is ours: drawn anew by each process, so that a text from outside cannot have it.
static OURS: LazyLock<String> = LazyLock::new(|| {
    let drawn = RandomState::new().build_hasher().finish();
    (0..8).map(|place| style_char((drawn >> (5 * place)) as u8 & 31)).collect()
});

fn style_char(number: u8) -> char {
    char::from_u32(*STYLE_MARKS.start() as u32 + u32::from(number)).unwrap_or(' ')
}

/// The mark of the style with this number; see [`terminal`].
pub(crate) fn style_mark(number: u8) -> String {
    format!("{}{}", style_char(number), *OURS)
}

/// A line as it may be printed: control characters, and those that reorder or hide text, become `\u001b`, as JSON and TOML write
/// them. `style` gives what stands for a style's mark. In a text of several lines, line feeds stay.
pub(crate) fn terminal(text: &str, is_one_line: bool, style: impl Fn(u8) -> String) -> String {
    let mut safe = String::with_capacity(text.len());
    let mut rest = text.chars();
    while let Some(c) = rest.next() {
        match c {
            '\n' if !is_one_line => safe.push(c),
            c if STYLE_MARKS.contains(&c) => match rest.as_str().strip_prefix(OURS.as_str()) {
                Some(after) => {
                    safe.push_str(&style((c as u32 - *STYLE_MARKS.start() as u32) as u8));
                    rest = after.chars();
                }
                None => push_seen(&mut safe, c),
            },
            c if is_unseen(c) => push_seen(&mut safe, c),
            c => safe.push(c),
        }
    }
    safe
}

/// A line in pieces: the number of the style, and the text, of each. `plain` is the style in which it begins.
pub(crate) fn pieces(text: &str, plain: u8) -> Vec<(u8, String)> {
    // What is safe has no NUL of its own.
    let marked = terminal(text, true, |number| format!("\0{}", char::from(b'a' + number)));
    let mut parts = marked.split('\0');
    let first = (plain, parts.next().unwrap_or_default().to_owned());
    let styled = parts.filter_map(|part| {
        let style = part.bytes().next()?.checked_sub(b'a')?;
        Some((style, part[1..].to_owned()))
    });
    std::iter::once(first).chain(styled).filter(|(_, text)| !text.is_empty()).collect()
}

/// A text from outside as part of a line, or of a text of several lines that is printed whole.
pub(crate) fn seen(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        if is_unseen(c) || STYLE_MARKS.contains(&c) {
            push_seen(&mut safe, c)
        } else {
            safe.push(c)
        }
    }
    safe
}

/// Text escaped for HTML and SVG.
pub(crate) fn html(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            // XML forbids control characters, even escaped.
            c if is_unseen(c) || STYLE_MARKS.contains(&c) => push_seen(&mut safe, c),
            c => safe.push(c),
        }
    }
    safe
}

/// A word of a command line, as a POSIX shell reads it: any text is one word, and runs nothing.
pub fn shell(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:@+,=".contains(c);
    match word {
        "" => "''".into(),
        _ if word.chars().all(plain) => word.into(),
        _ => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

/// A path as a word of a command line: no option, whatever it begins with.
pub fn shell_path(path: &std::path::Path) -> String {
    let path = path.to_string_lossy();
    if path.starts_with('-') { shell(&format!("./{path}")) } else { shell(&path) }
}

/// An option and its value as words of a command line; the value is no option, whatever it begins with.
pub fn shell_option(name: &str, value: &str) -> String {
    let between = if value.starts_with('-') { '=' } else { ' ' };
    format!("{name}{between}{}", shell(value))
}

/// Whether a terminal would obey this character instead of showing it, or show what follows in another order.
fn is_unseen(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}

fn push_seen(safe: &mut String, c: char) {
    // Writing to a string cannot fail; all of these characters have four digits.
    let _ = write!(safe, "\\u{:04x}", c as u32);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_would_obey_is_shown_and_all_else_is_as_it_was() {
        let text = "a\u{1b}[31m\u{7}\u{9b}2J\r\n\u{202e}b\u{200b}\u{7f}";
        let shown = r"a\u001b[31m\u0007\u009b2J\u000d\u000a\u202eb\u200b\u007f";
        assert_eq!(terminal(text, true, |_| String::new()), shown);
        assert_eq!(seen(text), shown);
        let plain = "übung – 3 · 10⁻⁴ \\ \"'$`";
        assert_eq!(terminal(plain, true, |_| String::new()), plain);
        assert_eq!(terminal("two\nlines", false, |_| String::new()), "two\nlines");
    }

    #[test]
    fn only_our_own_marks_are_styles() {
        let styled = |text: &str| terminal(text, true, |number| format!("<{number}>"));
        let ours = format!("a{}b{}", style_mark(1), style_mark(3));
        assert_eq!(styled(&ours), "a<1>b<3>");
        assert_eq!(styled("a\u{fdd1}b"), r"a\ufdd1b");
        // Whoever guesses its form still lacks what this process drew.
        let guessed = "\u{fdd1}".repeat(9);
        assert!(!styled(&guessed).contains('<') || OURS.chars().all(|c| c == '\u{fdd1}'));
    }

    #[test]
    fn a_line_in_pieces_has_the_style_of_each() {
        let text = format!("a\u{0}{}b{}c", style_mark(1), style_mark(5));
        let expected = [(5, r"a\u0000"), (1, "b"), (5, "c")];
        assert_eq!(pieces(&text, 5), expected.map(|(style, text)| (style, text.to_owned())));
        assert_eq!(pieces("", 5), []);
    }

    #[test]
    fn a_page_shows_markup_as_text() {
        assert_eq!(html("<b>\"R&D\"\u{0}'"), r"&lt;b&gt;&quot;R&amp;D&quot;\u0000&#39;");
    }

    #[test]
    fn json_stays_json_with_the_same_text() {
        let value = serde_json::json!({ "name": "\u{1b}\u{202e}\n\u{9b}" });
        let printed = terminal(&value.to_string(), true, |_| String::new());
        assert!(!printed.contains(is_unseen));
        assert_eq!(serde_json::from_str::<serde_json::Value>(&printed).unwrap(), value);
    }

    #[test]
    #[cfg(unix)]
    fn a_shell_reads_any_word_back_and_runs_nothing() {
        for word in [
            "",
            "plain",
            "a b",
            "$(touch x)",
            "`id`",
            "\"; id; \"",
            "it's",
            "''",
            "~",
            "*",
            "a\nb",
            "!!",
            "\\",
        ] {
            let script = format!("printf %s {}", shell(word));
            let output = std::process::Command::new("sh").args(["-c", &script]).output().unwrap();
            assert_eq!(String::from_utf8(output.stdout).unwrap(), word);
        }
        assert_eq!(shell_path(std::path::Path::new("-rf")), "./-rf");
    }
}
