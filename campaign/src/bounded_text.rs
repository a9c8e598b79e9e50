//! Texts from outside in messages: of what nobody would read, the beginning.

use std::borrow::Cow;

/// So much of a quoted text is repeated \[characters\].
pub const QUOTED_MAX: usize = 200;

/// No message is longer \[characters\].
pub const MESSAGE_MAX: usize = 2000;

/// A message in which quotations, and the whole, have bounds. A text is quoted between two backticks or two of `quotes`.
pub fn bounded<'a>(message: &'a str, quotes: &[char]) -> Cow<'a, str> {
    // Nearly all are short.
    if message.len() <= QUOTED_MAX {
        return message.into();
    }
    let is_quote = |c: char| c == '`' || quotes.contains(&c);
    let mut kept = String::new();
    let mut rest = message;
    while let Some(opens) = rest.find(is_quote) {
        let quote = rest[opens..].chars().next().unwrap_or('`');
        let begins = opens + quote.len_utf8();
        let Some(length) = rest[begins..].find(quote) else { break };
        kept.push_str(&rest[..begins]);
        kept.push_str(&shortened(&rest[begins..begins + length], QUOTED_MAX));
        kept.push(quote);
        rest = &rest[begins + length + quote.len_utf8()..];
    }
    kept.push_str(rest);
    match shortened(&kept, MESSAGE_MAX) {
        Cow::Owned(short) => short.into(),
        Cow::Borrowed(_) => kept.into(),
    }
}

/// The beginning of a text, and how long it is, if that is more than `max` characters; what is returned never is.
pub fn shortened(text: &str, max: usize) -> Cow<'_, str> {
    if text.chars().nth(max).is_none() {
        return text.into();
    }
    let said = format!("... ({} characters)", text.chars().count());
    let beginning: String = text.chars().take(max.saturating_sub(said.len())).collect();
    (beginning + &said).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_quotation_is_cut_and_what_is_said_of_it_stays() {
        let long = "é".repeat(100_000);
        let said =
            bounded(&format!("a.toml: unknown field `{long}`, expected `b`"), &[]).into_owned();
        let short = format!("{}... (100000 characters)", "é".repeat(200 - 23));
        assert_eq!(said, format!("a.toml: unknown field `{short}`, expected `b`"));
        assert_eq!(bounded(&said, &[]), said, "what is short already stays");
        let said = bounded(&format!("invalid value '{long}' for '--a'"), &['\'']).into_owned();
        assert_eq!(said, format!("invalid value '{short}' for '--a'"));
    }

    #[test]
    fn no_message_is_longer_than_its_bound_wherever_its_quotes_are() {
        for text in ["a`", "`", "a", "'", "``a"] {
            let said = bounded(&text.repeat(50_000), &['\'']).into_owned();
            assert!(said.chars().count() <= MESSAGE_MAX, "{text}");
        }
        let fine = format!("{}`{}`", "word ".repeat(200), "a".repeat(QUOTED_MAX));
        assert_eq!(bounded(&fine, &[]), fine);
    }
}
