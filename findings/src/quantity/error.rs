//! Why a text is not the quantity that is expected.

use std::fmt;

/// Why a text is not the quantity that is expected.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityError {
    pub(super) what: &'static str,
    pub(super) text: String,
    pub(super) problem: Problem,
    pub(super) example: &'static str,
}

/// What is wrong with the text.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Problem {
    NoNumber,
    NotFinite,
    NoUnit { number: String },
    UnknownUnit { unit: String, column: usize, known: Vec<&'static str> },
}

impl fmt::Display for QuantityError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, text, problem, example } = self;
        match problem {
            Problem::NoNumber => {
                write!(f, "no number at the start of `{text}`: write it like {example}")
            }
            Problem::NotFinite => write!(f, "`{text}` is too large: write it like {example}"),
            Problem::NoUnit { number } => {
                write!(f, "`{number}` has no unit: write it like {example}")
            }
            Problem::UnknownUnit { unit, column, known } => write!(
                f,
                "`{unit}` (at character {column} of `{text}`) is not a unit of {what}: use one of {}; \
                 for example {example}",
                known.join(", ")
            ),
        }
    }
}

impl std::error::Error for QuantityError {}
