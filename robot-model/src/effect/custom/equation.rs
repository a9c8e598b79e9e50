//! What does a user write about an effect of their own? An equation, with units and ranges.
//!
//! Whether it can be fitted is tested in `build.rs`.

use core::ops::Range;
use std::collections::BTreeMap;

use super::error::{CustomError, CustomProblem, DefinitionPart};
use super::parse::parse;
use super::target::{Per, Target};

/// What a user writes about an effect of their own.
#[derive(Clone, Debug, PartialEq)]
pub struct Custom {
    /// Its id in `model.toml` and JSON.
    pub id: String,
    /// What it changes.
    pub target: Target,
    /// What it is a rate of.
    pub per: Per,
    /// The right-hand side.
    pub expression: String,
    /// Units of parameters, where declared; the others follow from the expression.
    pub units: BTreeMap<String, String>,
    /// Least and greatest plausible values of parameters, where declared.
    pub ranges: BTreeMap<String, [f64; 2]>,
}

impl Custom {
    /// Reads `dtheta = k * v^2 * omega`, or `dtheta/ds = ...`: target, per what, and the right-hand
    /// side. Errors point into the whole text.
    pub fn from_equation(text: &str) -> Result<Self, CustomError> {
        let fail = |at: Range<usize>, problem: CustomProblem| {
            Err(CustomError::new(DefinitionPart::Target, at, problem))
        };
        let Some(equals) = text.find('=') else {
            return fail(0..text.len(), CustomProblem::NoEquals);
        };
        let left = text[..equals].trim();
        let begin = text.len() - text.trim_start().len();
        let at = begin.min(equals)..begin.min(equals) + left.len();
        let (name, per) = match left.split_once('/') {
            None => (left, Per::Second),
            Some((name, per)) => match per.trim() {
                "dt" => (name, Per::Second),
                "ds" => (name, Per::Metre),
                "dtheta" => (name, Per::Radian),
                _ => return fail(at, CustomProblem::Target(left.to_owned())),
            },
        };
        let Some(target) = Target::ALL.into_iter().find(|target| target.name() == name.trim())
        else {
            return fail(at, CustomProblem::Target(left.to_owned()));
        };
        let rest = &text[equals + 1..];
        let from = equals + 1 + rest.len() - rest.trim_start().len();
        let custom = Self {
            id: format!("custom_{}", target.name()),
            target,
            per,
            expression: rest.trim().to_owned(),
            units: BTreeMap::new(),
            ranges: BTreeMap::new(),
        };
        // An error in the expression points into the equation.
        parse(&custom.expression).map_err(|error| CustomError {
            at: error.at.start + from..error.at.end + from,
            ..error
        })?;
        Ok(custom)
    }

    /// The equation, as a user would write it.
    pub fn equation(&self) -> String {
        let per = match self.per {
            Per::Second => "dt",
            Per::Metre => "ds",
            Per::Radian => "dtheta",
        };
        format!("{}/{per} = {}", self.target.name(), self.expression)
    }

    /// The names of its parameters, in the order in which they appear.
    pub fn parameters(&self) -> Result<Vec<String>, CustomError> {
        Ok(parse(&self.expression)?.1)
    }
}
