//! Numbers in messages to people.

use core::fmt;

/// Formats a number for people: `1e300`, not a one with three hundred zeros.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readable(pub f64);

impl fmt::Display for Readable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        let plain = size == 0.0 || (1e-9..1e15).contains(&size) || !size.is_finite();
        if plain { write!(f, "{}", self.0) } else { write!(f, "{:e}", self.0) }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::string::ToString;

    use super::*;

    #[test]
    fn no_number_is_longer_than_its_digits() {
        for (value, text) in [
            (0.0, "0"),
            (-0.25, "-0.25"),
            (1e14, "100000000000000"),
            (-1e300, "-1e300"),
            (1.5e-12, "1.5e-12"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(Readable(value).to_string(), text);
        }
        assert!(Readable(-f64::MIN_POSITIVE / 3.0).to_string().len() < 25);
    }
}
