//! What does a user write about an effect of their own? An equation, units and ranges; what follows from them.

use core::ops::Range;
use std::collections::BTreeMap;

use super::amplitudes::amplitudes;
use super::dimensions::{LeftSide, units};
use super::error::{DefinitionPart, ExpressionError, ExpressionProblem};
use super::parse::parse;
use super::tree::{Names, Tree};
use super::unit::Unit;

/// An equation in its two sides, with their places in the text.
pub(crate) struct Sides<'t> {
    pub left: &'t str,
    pub left_at: Range<usize>,
    pub right: &'t str,
    /// Where the right side begins.
    pub right_from: usize,
}

impl<'t> Sides<'t> {
    /// Splits `left = right`.
    pub fn of(text: &'t str) -> Result<Self, ExpressionError> {
        let Some(equals) = text.find('=') else {
            let problem = ExpressionProblem::NoEquals;
            return Err(ExpressionError::new(DefinitionPart::Target, 0..text.len(), problem));
        };
        let left = text[..equals].trim();
        let begin = (text.len() - text.trim_start().len()).min(equals);
        let rest = &text[equals + 1..];
        Ok(Self {
            left,
            left_at: begin..begin + left.len(),
            right: rest.trim(),
            right_from: equals + 1 + rest.len() - rest.trim_start().len(),
        })
    }

    /// That nothing can be changed by this left side.
    pub fn wrong_target(&self) -> ExpressionError {
        let problem = ExpressionProblem::Target(self.left.to_owned());
        ExpressionError::new(DefinitionPart::Target, self.left_at.clone(), problem)
    }

    /// An error in the right side, as one in the whole equation.
    pub fn within(&self, error: ExpressionError) -> ExpressionError {
        let at = error.at.start + self.right_from..error.at.end + self.right_from;
        ExpressionError { at, ..error }
    }
}

/// Whether an effect can have this id: small letters, digits and `_`, and no effect of the catalogue.
pub(crate) fn check_id(id: &str, is_built_in: bool) -> Result<(), ExpressionError> {
    let sound = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    if id.is_empty() || !id.chars().all(sound) || is_built_in {
        let problem = ExpressionProblem::Id(id.to_owned());
        return Err(ExpressionError::new(DefinitionPart::Id, 0..id.len(), problem));
    }
    Ok(())
}

/// What a user declares of parameters, by name.
#[derive(Clone, Copy)]
pub(crate) struct Declared<'a> {
    /// Units; the others follow from the expression.
    pub units: &'a BTreeMap<String, String>,
    /// Least and greatest plausible values.
    pub ranges: &'a BTreeMap<String, [f64; 2]>,
}

/// A parameter of an expression.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ExpressionParameter {
    pub name: String,
    pub unit: String,
    pub low: f64,
    pub high: f64,
    /// Linear, and without it the expression vanishes.
    pub is_amplitude: bool,
}

/// What an expression is about: its variables, their values at a few samples, and the left side of its equation.
pub(crate) struct Context<'a> {
    pub names: Names,
    pub samples: &'a [Vec<f64>],
    pub left_side: LeftSide,
}

impl Context<'_> {
    /// Reads an expression; `limit` gives the plausible limit of an amplitude.
    pub fn read(
        &self,
        expression: &str,
        declared: Declared<'_>,
        limit: impl Fn(&Tree, usize) -> f64,
    ) -> Result<(Tree, Vec<ExpressionParameter>), ExpressionError> {
        let (tree, names) = parse(expression, self.names)?;
        let of_units = declared_units(&declared, &names)?;
        let amplitudes = amplitudes(&tree, names.len(), self.samples).ok_or_else(|| {
            ExpressionError::in_expression(tree.at.clone(), ExpressionProblem::DoesNotVanish)
        })?;
        let units = units(&tree, self.names.variables, &self.left_side, &of_units, &names)?;
        let mut parameters = Vec::with_capacity(names.len());
        for (index, (name, unit)) in names.iter().zip(units).enumerate() {
            let is_amplitude = amplitudes.contains(&index);
            let shown = declared.units.get(name);
            let shown = shown.map_or_else(|| unit.to_string(), |unit| unit.trim().to_owned());
            let [low, high] = match declared.ranges.get(name) {
                Some(range) => sound_range(name, *range, is_amplitude)?,
                None if is_amplitude => {
                    let limit = limit(&tree, index);
                    [-limit, limit]
                }
                None => [unit.typical() / SHAPE_TIMES, unit.typical() * SHAPE_TIMES],
            };
            if !is_plausible(low, high) {
                let problem = ExpressionProblem::NoPlausibleValue(name.clone());
                return Err(ExpressionError::in_expression(tree.at.clone(), problem));
            }
            let (name, unit) = (name.clone(), shown);
            parameters.push(ExpressionParameter { name, unit, low, high, is_amplitude });
        }
        if let Some((name, _)) = declared.ranges.iter().find(|(name, _)| !names.contains(name)) {
            let part = DefinitionPart::Range(name.clone());
            return Err(ExpressionError::new(part, 0..0, no_parameter(name, &names)));
        }
        Ok((tree, parameters))
    }
}

/// A shape is looked for up to so many times a typical value of its unit, and down to this share.
const SHAPE_TIMES: f64 = 30.0;

fn declared_units(
    declared: &Declared<'_>,
    names: &[String],
) -> Result<Vec<Option<Unit>>, ExpressionError> {
    let mut units = vec![None; names.len()];
    for (name, unit) in declared.units {
        let part = DefinitionPart::Unit(name.clone());
        let fail = |problem| ExpressionError::new(part, 0..unit.len(), problem);
        match names.iter().position(|parameter| parameter == name) {
            Some(index) => units[index] = Some(Unit::parse(unit).map_err(fail)?),
            None => return Err(fail(no_parameter(name, names))),
        }
    }
    Ok(units)
}

fn sound_range(
    name: &str,
    [low, high]: [f64; 2],
    of_amplitude: bool,
) -> Result<[f64; 2], ExpressionError> {
    let sound = low.is_finite() && high.is_finite() && low < high;
    let holds_zero = low <= 0.0 && high >= 0.0;
    if !sound || (of_amplitude && !holds_zero) {
        let (name, range) = (name.to_owned(), [low, high]);
        let part = DefinitionPart::Range(name.clone());
        let problem = ExpressionProblem::Range { name, range, of_amplitude };
        return Err(ExpressionError::new(part, 0..0, problem));
    }
    Ok([low, high])
}

/// Whether a range can be searched: neither so wide nor so narrow that its numbers overflow when they are squared.
fn is_plausible(low: f64, high: f64) -> bool {
    const SIZES: core::ops::RangeInclusive<f64> = 1e-100..=1e100;
    let bounded = |end: f64| end == 0.0 || SIZES.contains(&end.abs());
    bounded(low) && bounded(high) && low < high
}

fn no_parameter(name: &str, parameters: &[String]) -> ExpressionProblem {
    ExpressionProblem::NoParameter { name: name.to_owned(), parameters: parameters.to_vec() }
}

/// Where a search begins: amplitudes zero, and each shape at these shares of its range, logarithmic where the range is positive.
/// Each parameter is its least and greatest value, and whether it is an amplitude.
pub(crate) fn starts(parameters: &[(f64, f64, bool)], shares: &[f64]) -> Vec<Vec<f64>> {
    if parameters.iter().all(|(.., is_amplitude)| *is_amplitude) {
        return vec![vec![0.0; parameters.len()]];
    }
    let start = |share: &f64| {
        let at = |&(low, high, is_amplitude): &(f64, f64, bool)| match is_amplitude {
            true => 0.0,
            false if low > 0.0 => low * (high / low).powf(*share),
            false => low + share * (high - low),
        };
        parameters.iter().map(at).collect()
    };
    shares.iter().map(start).collect()
}
