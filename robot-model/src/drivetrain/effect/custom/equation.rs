//! What does a user write about an effect of the motors? An equation, with units and ranges.
//!
//! Whether it can be fitted is tested in `build.rs`.

use std::collections::BTreeMap;

use super::target::{MotorTarget, Motors};
use super::variables::NAMES;
use crate::expression::{ExpressionError, Sides, parse};

/// What a user writes about an effect of the motors.
#[derive(Clone, Debug, PartialEq)]
pub struct MotorCustom {
    /// Its id in `motors.toml` and JSON.
    pub id: String,
    /// What it changes.
    pub target: MotorTarget,
    /// Which motors it changes.
    pub motors: Motors,
    /// The right-hand side.
    pub expression: String,
    /// Units of parameters, where declared; the others follow from the expression.
    pub units: BTreeMap<String, String>,
    /// Least and greatest plausible values of parameters, where declared.
    pub ranges: BTreeMap<String, [f64; 2]>,
}

impl MotorCustom {
    /// Reads `dV = q * v * abs(v)`, or `dkS_left = ...`. Errors point into the whole text.
    pub fn from_equation(text: &str) -> Result<Self, ExpressionError> {
        let sides = Sides::of(text)?;
        let mut all = MotorTarget::ALL
            .into_iter()
            .flat_map(|target| Motors::ALL.map(|motors| (target, motors)));
        let (target, motors) = all
            .find(|(target, motors)| {
                sides.left.strip_prefix(target.name()) == Some(motors.suffix())
            })
            .ok_or_else(|| sides.wrong_target())?;
        let custom = Self {
            id: format!("custom_{}", sides.left.to_ascii_lowercase()),
            target,
            motors,
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
        format!("{}{} = {}", self.target.name(), self.motors.suffix(), self.expression)
    }

    /// The names of its parameters, in the order in which they appear.
    pub fn parameters(&self) -> Result<Vec<String>, ExpressionError> {
        Ok(parse(&self.expression, NAMES)?.1)
    }
}
