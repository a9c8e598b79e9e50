//! Errors of the operating system, as a user reads them.

/// A text without the numbers that the standard library adds to the system's own errors, ` (os error 2)`: the words
/// before them say the same to a user.
pub fn without_os_numbers(text: &str) -> String {
    const BEGINS: &str = " (os error ";
    let mut kept = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once(BEGINS) {
        kept.push_str(before);
        let number = after.find(|c: char| c != '-' && !c.is_ascii_digit()).unwrap_or(0);
        rest = match after[number..].strip_prefix(')') {
            Some(behind) if number > 0 => behind,
            _ => {
                kept.push_str(BEGINS);
                after
            }
        };
    }
    kept + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_whole_numbers_of_the_system_are_left_out() {
        for (text, kept) in [
            ("a (os error 13) b (os error -5)", "a b"),
            ("a ((os error 2))", "a ((os error 2))"),
            ("a (b (os error 2))", "a (b)"),
            ("a (os error )", "a (os error )"),
            ("a (os error 2", "a (os error 2"),
            ("", ""),
        ] {
            assert_eq!(without_os_numbers(text), kept);
        }
    }
}
