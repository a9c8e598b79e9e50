//! What is the value of an expression, with its exact derivatives by the parameters?

use super::tree::{Function, Node, Operator, Tree};
use crate::numeric::jet::{Jet, PARAMETERS_MAX};

/// The value; infinite or NaN where the expression has none. `variable` gives the values of the variables.
pub(crate) fn evaluate(
    tree: &Tree,
    p: &[Jet; PARAMETERS_MAX],
    variable: &dyn Fn(usize) -> f64,
) -> Jet {
    let at = |tree: &Tree| evaluate(tree, p, variable);
    match &tree.node {
        Node::Number(value, _) => Jet::constant(*value),
        Node::Variable(index) => Jet::constant(variable(*index)),
        Node::Parameter(index) => p[*index],
        Node::Negative(inner) => -at(inner),
        Node::Binary(operator, left, right) => {
            let (a, b) = (at(left), at(right));
            match operator {
                Operator::Add => a + b,
                Operator::Subtract => a - b,
                Operator::Multiply => a * b,
                Operator::Divide => a / b,
                Operator::Power => power(a, b),
            }
        }
        Node::Call(function, arguments) => {
            let x = at(&arguments[0]);
            let v = x.value;
            match function {
                Function::Sin => x.chain(v.sin(), v.cos()),
                Function::Cos => x.chain(v.cos(), -v.sin()),
                Function::Tan => x.chain(v.tan(), v.cos().powi(-2)),
                Function::Exp => x.exp(),
                Function::Ln => x.chain(v.ln(), 1.0 / v),
                Function::Sqrt => x.chain(v.sqrt(), 0.5 / v.sqrt()),
                Function::Tanh => x.chain(v.tanh(), 1.0 - v.tanh().powi(2)),
                Function::Abs => x.chain(v.abs(), sign(v)),
                Function::Sign => Jet::constant(sign(v)),
                Function::Min | Function::Max => {
                    let y = at(&arguments[1]);
                    let first = (v < y.value) == (*function == Function::Min);
                    if first { x } else { y }
                }
            }
        }
    }
}

/// The sign, zero at zero.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// a^b, with d = b a^(b-1) da + a^b ln a db.
fn power(a: Jet, b: Jet) -> Jet {
    let value = a.value.powf(b.value);
    let slope = if b.value == 0.0 { 0.0 } else { b.value * a.value.powf(b.value - 1.0) };
    let mut result = Jet::constant(value);
    for (j, by) in result.by.iter_mut().enumerate() {
        // A zero factor gives zero, even if the other one is not finite.
        let base = if a.by[j] == 0.0 { 0.0 } else { slope * a.by[j] };
        let exponent = if b.by[j] == 0.0 { 0.0 } else { value * a.value.ln() * b.by[j] };
        *by = base + exponent;
    }
    result
}
