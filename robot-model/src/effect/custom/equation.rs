//! What does a user write about an effect of their own? An equation, with units and ranges.
//!
//! Whether it can be fitted is tested in `build.rs`.

use std::collections::BTreeMap;

use super::target::{Per, Target};
use super::variables::NAMES;
use crate::expression::{ExpressionError, Sides, parse};

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
    pub fn from_equation(text: &str) -> Result<Self, ExpressionError> {
        let sides = Sides::of(text)?;
        let (name, per) = match sides.left.split_once('/') {
            None => (sides.left, Per::Second),
            Some((name, per)) => match per.trim() {
                "dt" => (name, Per::Second),
                "ds" => (name, Per::Metre),
                "dtheta" => (name, Per::Radian),
                _ => return Err(sides.wrong_target()),
            },
        };
        let target = Target::ALL.into_iter().find(|target| target.name() == name.trim());
        let target = target.ok_or_else(|| sides.wrong_target())?;
        let custom = Self {
            id: format!("custom_{}", target.name()),
            target,
            per,
            expression: sides.right.to_owned(),
            units: BTreeMap::new(),
            ranges: BTreeMap::new(),
        };
        // An error in the expression points into the equation.
        parse(&custom.expression, NAMES).map_err(|error| sides.within(error))?;
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
    pub fn parameters(&self) -> Result<Vec<String>, ExpressionError> {
        Ok(parse(&self.expression, NAMES)?.1)
    }
}
