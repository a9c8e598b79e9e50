//! Why can an expression not be used? What is wrong, where, and what to try.

use core::fmt;
use core::ops::Range;

/// Which part of a [`super::Custom`] is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DefinitionPart {
    /// The id.
    Id,
    /// The left-hand side of an equation.
    Target,
    /// The expression.
    Expression,
    /// The unit of this parameter.
    Unit(String),
    /// The range of this parameter.
    Range(String),
}

/// Why an expression cannot be used, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CustomError {
    /// Which part is wrong.
    pub part: DefinitionPart,
    /// Where in that part, in bytes.
    pub at: Range<usize>,
    /// What is wrong.
    pub problem: String,
    /// What to try.
    pub hint: String,
}

impl CustomError {
    pub(super) fn new(part: DefinitionPart, at: Range<usize>, problem: &str, hint: &str) -> Self {
        Self { part, at, problem: problem.to_owned(), hint: hint.to_owned() }
    }

    pub(super) fn in_expression(at: Range<usize>, problem: &str, hint: &str) -> Self {
        Self::new(DefinitionPart::Expression, at, problem, hint)
    }
}

impl fmt::Display for CustomError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.problem)
    }
}

impl core::error::Error for CustomError {}
