//! One cell of a table.

/// Its number; `NAN` if it is empty. Where commas separate no cells, one may be the point of a number: `0,25`.
pub(super) fn number(text: &str, delimiter: u8) -> Option<f64> {
    if text.is_empty() {
        return Some(f64::NAN);
    }
    let of_comma = || {
        let is_point = delimiter != b',' && text.matches(',').count() == 1 && !text.contains('.');
        is_point.then(|| text.replace(',', ".").parse().ok()).flatten()
    };
    text.parse().ok().or_else(of_comma)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comma_is_a_point_where_it_separates_nothing() {
        assert_eq!(number("-0,25", b';'), Some(-0.25));
        assert_eq!(number("0.25", b';'), Some(0.25));
        for (text, delimiter) in [("1,234.5", b';'), ("1,234,5", b';'), ("0,25", b','), ("x", b';')]
        {
            assert_eq!(number(text, delimiter), None, "{text}");
        }
        assert!(number("", b',').is_some_and(f64::is_nan));
    }
}
