//! Why a scenario cannot be used: which file, which line, what to do.

use core::fmt;
use core::ops::Range;

use shared_proto::Readable;
use toml::de::{DeTable, DeValue};

use crate::plant::ParameterError;

/// Why a scenario cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScenarioError {
    /// The file.
    pub origin: String,
    /// Line and column, from 1, where known.
    pub place: Option<(usize, usize)>,
    /// What is wrong.
    pub problem: String,
    /// What to do.
    pub hint: String,
}

impl fmt::Display for ScenarioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.origin)?;
        if let Some((line, column)) = self.place {
            write!(f, ", line {line}, column {column}")?;
        }
        write!(f, ": {}\n  {}", self.problem, self.hint)
    }
}

impl core::error::Error for ScenarioError {}

impl ScenarioError {
    /// A file that cannot be read.
    pub fn unreadable(origin: &str, error: &std::io::Error) -> Self {
        Self {
            origin: origin.into(),
            place: None,
            problem: format!("cannot be read: {error}"),
            hint: "give the path of a scenario file; the ones that come with the simulator are in \
                   sim-target/scenarios"
                .into(),
        }
    }

    pub(super) fn syntax(origin: &str, text: &str, error: &toml::de::Error) -> Self {
        let problem = error.message().replace('\n', " ");
        let hint = if problem.contains("unknown field") {
            "correct the name, or leave the line out"
        } else if problem.contains("missing field") {
            "add it above the first table"
        } else if problem.contains("invalid type") {
            "write the value as the expected type"
        } else {
            "correct this line; a scenario is a TOML file"
        };
        let place = error.span().map(|span| line_and_column(text, span.start));
        Self { origin: origin.into(), place, problem, hint: hint.into() }
    }

    pub(super) fn value(origin: &str, text: &str, error: &ParameterError) -> Self {
        Self {
            origin: origin.into(),
            place: locate(text, &error.field).map(|span| line_and_column(text, span.start)),
            problem: format!("{} = {} is out of range", error.field, Readable(error.value)),
            hint: format!("{} must be {}", error.field, error.expected),
        }
    }
}

/// Where the text has the field at this dotted path, or the innermost table on that path.
fn locate(text: &str, path: &str) -> Option<Range<usize>> {
    let document = DeTable::parse(text).ok()?;
    let mut table = document.get_ref();
    let mut found = None;
    for key in path.split('.') {
        let Some(value) = table.get(key) else { break };
        found = Some(value.span());
        let DeValue::Table(inner) = value.get_ref() else { break };
        table = inner;
    }
    found
}

/// Line and column, from 1, of a byte in the text.
fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let before = text.get(..byte).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}
