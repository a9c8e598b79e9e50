//! Which units do the parameters of an expression have?
//!
//! The units of parameters that are not declared follow from the expression: each sum, function and
//! the target itself is an equation in the exponents, linear in those of the unknown units.

use super::error::{ExpressionError, ExpressionProblem, RequiredLeftSide, RequiredUnit};
use super::tree::{Function, Node, Operator, Tree, Variable};
use super::unit::Unit;
use crate::numeric::jet::PARAMETERS_MAX;

/// What an equation is of: the right side has the unit of the left one.
pub(crate) struct LeftSide {
    /// What changes.
    pub quantity: &'static str,
    /// Per what, if it is a rate.
    pub per: Option<&'static str>,
    /// Its unit.
    pub unit: Unit,
}

/// Exponents that differ by less are the same: a third is read as 0.333333.
const EXPONENT_TOLERANCE: f64 = 1e-5;

/// A unit that may depend on those of the parameters: exponents `known + sum of[j] unit_j`.
#[derive(Clone, Copy, Debug)]
struct Open {
    known: [f64; 4],
    of: [f64; PARAMETERS_MAX],
}

impl Open {
    fn known(unit: Unit) -> Self {
        Self { known: unit.0, of: [0.0; PARAMETERS_MAX] }
    }

    /// This one plus `times` another.
    fn plus(mut self, other: Self, times: f64) -> Self {
        self.known.iter_mut().zip(other.known).for_each(|(a, b)| *a += times * b);
        self.of.iter_mut().zip(other.of).for_each(|(a, b)| *a += times * b);
        self
    }
}

/// Something that must have no unit, and what it is.
struct Equation {
    open: Open,
    at: core::ops::Range<usize>,
    required: RequiredUnit,
}

/// The unit of each parameter, declared or following from the expression.
pub(crate) fn units(
    tree: &Tree,
    variables: &[Variable],
    left_side: &LeftSide,
    declared: &[Option<Unit>],
    names: &[String],
) -> Result<Vec<Unit>, ExpressionError> {
    let mut equations = Vec::new();
    let whole = unit_of(tree, (variables, declared), &mut equations)?;
    let &LeftSide { quantity, per, unit } = left_side;
    let required = RequiredLeftSide { quantity, per, unit: unit.to_string() };
    equations.push(Equation {
        open: whole.plus(Open::known(unit), -1.0),
        at: tree.at.clone(),
        required: RequiredUnit::LeftSide(Box::new(required)),
    });
    let mut solved: Vec<Option<(usize, Open)>> = vec![None; names.len()];
    for equation in equations {
        let mut open = equation.open;
        for (index, open_unit) in &solved.iter().flatten().copied().collect::<Vec<_>>() {
            let times = open.of[*index];
            if times != 0.0 {
                open.of[*index] = 0.0;
                open = open.plus(*open_unit, times);
            }
        }
        match (0..names.len()).find(|j| open.of[*j].abs() > 1e-9) {
            Some(j) => {
                // unit_j = -(rest) / coefficient
                let coefficient = open.of[j];
                open.of[j] = 0.0;
                let rest = Open { known: [0.0; 4], of: [0.0; PARAMETERS_MAX] };
                let unit = rest.plus(open, -1.0 / coefficient);
                for (_, earlier) in solved.iter_mut().flatten() {
                    let times = earlier.of[j];
                    earlier.of[j] = 0.0;
                    *earlier = earlier.plus(unit, times);
                }
                solved[j] = Some((j, unit));
            }
            None if open.known.iter().any(|power| power.abs() > EXPONENT_TOLERANCE) => {
                let factor = Unit(open.known).to_string();
                let problem = ExpressionProblem::WrongUnit { required: equation.required, factor };
                return Err(ExpressionError::in_expression(equation.at, problem));
            }
            None => {}
        }
    }
    (0..names.len())
        .map(|j| {
            if let Some(unit) = declared[j] {
                return Ok(unit);
            }
            match solved[j] {
                Some((_, open)) if open.of.iter().all(|power| power.abs() < 1e-9) => {
                    let unit = Unit(open.known);
                    if unit.can_be_declared() {
                        return Ok(unit);
                    }
                    let problem = ExpressionProblem::NotAUnit(unit.to_string());
                    Err(ExpressionError::in_expression(tree.at.clone(), problem))
                }
                _ => {
                    let problem = ExpressionProblem::UnknownUnit(names[j].clone());
                    Err(ExpressionError::in_expression(tree.at.clone(), problem))
                }
            }
        })
        .collect()
}

/// The unit of a tree; what has to hold in it is added to `equations`.
fn unit_of(
    tree: &Tree,
    (variables, declared): (&[Variable], &[Option<Unit>]),
    equations: &mut Vec<Equation>,
) -> Result<Open, ExpressionError> {
    let one = Open::known(Unit::ONE);
    let known = |tree: &Tree, equations: &mut Vec<Equation>| {
        unit_of(tree, (variables, declared), equations)
    };
    Ok(match &tree.node {
        Node::Number(_, unit) => Open::known(*unit),
        Node::Variable(variable) => Open::known(variables[*variable].unit),
        Node::Parameter(index) => match declared[*index] {
            Some(unit) => Open::known(unit),
            None => {
                let mut open = one;
                open.of[*index] = 1.0;
                open
            }
        },
        Node::Negative(inner) => known(inner, equations)?,
        Node::Binary(operator, left, right) => {
            let (a, b) = (known(left, equations)?, known(right, equations)?);
            match operator {
                Operator::Multiply => a.plus(b, 1.0),
                Operator::Divide => a.plus(b, -1.0),
                Operator::Add | Operator::Subtract => common(left, right, (a, b), tree, equations),
                Operator::Power => unit_of_power((left, a), (right, b), equations),
            }
        }
        Node::Call(function, arguments) => {
            let units: Vec<Open> = arguments
                .iter()
                .map(|argument| known(argument, equations))
                .collect::<Result<_, _>>()?;
            match function {
                Function::Abs => units[0],
                Function::Sign => one,
                Function::Sqrt => one.plus(units[0], 0.5),
                Function::Min | Function::Max => {
                    let pair = (units[0], units[1]);
                    common(&arguments[0], &arguments[1], pair, tree, equations)
                }
                _ => {
                    equations.push(Equation {
                        open: units[0],
                        at: arguments[0].at.clone(),
                        required: RequiredUnit::Argument(function.name()),
                    });
                    one
                }
            }
        }
    })
}

/// The unit of a power: its exponent has none, nor has its base if the exponent is free.
fn unit_of_power(
    (base, unit): (&Tree, Open),
    (exponent, exponent_unit): (&Tree, Open),
    equations: &mut Vec<Equation>,
) -> Open {
    let one = Open::known(Unit::ONE);
    equations.push(Equation {
        open: exponent_unit,
        at: exponent.at.clone(),
        required: RequiredUnit::Exponent,
    });
    if let Some(power) = constant(exponent) {
        return one.plus(unit, power);
    }
    equations.push(Equation { open: unit, at: base.at.clone(), required: RequiredUnit::Base });
    one
}

/// The common unit of two operands; a plain 0 has any unit.
fn common(
    left: &Tree,
    right: &Tree,
    (a, b): (Open, Open),
    whole: &Tree,
    equations: &mut Vec<Equation>,
) -> Open {
    let nothing = |tree: &Tree| tree.node == Node::Number(0.0, Unit::ONE);
    if nothing(left) {
        return b;
    }
    if !nothing(right) {
        equations.push(Equation {
            open: a.plus(b, -1.0),
            at: whole.at.clone(),
            required: RequiredUnit::Same,
        });
    }
    a
}

/// The value of a tree of plain numbers.
pub(super) fn constant(tree: &Tree) -> Option<f64> {
    match &tree.node {
        Node::Number(value, _) => Some(*value),
        Node::Negative(inner) => constant(inner).map(|value| -value),
        Node::Binary(Operator::Divide, a, b) => Some(constant(a)? / constant(b)?),
        _ => None,
    }
}
