//! How is the text of an expression read? The result is a tree in which every node has its place in the text.
//!
//! ```text
//! sum     = product (("+" | "-") product)*
//! product = power (("*" | "/") power)*
//! power   = "-" power | atom ("^" power)?
//! atom    = number ("[" unit "]")? | name | function "(" sum ("," sum)* ")" | "(" sum ")"
//! ```
//!
//! `^` binds tighter than a minus before it, and to the right: -v^2 is -(v^2). A number may carry a unit:
//! `0.3[m/s]`. The parser is our own: units are checked on the tree, and an error shows its place.

use core::ops::Range;

use super::dimensions::constant;
use super::error::{Expected, ExpressionError, ExpressionProblem};
use super::tree::{Function, Names, Node, Operator, Tree, Variable};
use super::unit::{EXPONENT_MAX, Unit};
use crate::numeric::jet::PARAMETERS_MAX;

/// Deepest nesting: nobody writes more, and a longer text could exhaust the stack.
const DEPTH_MAX: usize = 64;
/// Most numbers, names and operators: a sum of that many terms is a tree as deep.
const NODES_MAX: usize = 1000;

/// Reads the right-hand side. The names of the parameters come in the order in which they appear.
pub(crate) fn parse(
    text: &str,
    Names { variables, reserved }: Names,
) -> Result<(Tree, Vec<String>), ExpressionError> {
    let mut parser =
        Parser { text, variables, reserved, at: 0, depth: 0, nodes: 0, parameters: Vec::new() };
    let tree = parser.sum()?;
    parser.space();
    match parser.rest().chars().next() {
        None => Ok((tree, parser.parameters)),
        Some(')') => Err(parser.error(ExpressionProblem::ClosesNothing)),
        Some(found) => {
            let expected = Expected::Operator;
            Err(parser.error(ExpressionProblem::Unexpected { found, expected }))
        }
    }
}

struct Parser<'t> {
    text: &'t str,
    variables: &'static [Variable],
    reserved: &'static [&'static str],
    at: usize,
    depth: usize,
    nodes: usize,
    parameters: Vec<String>,
}

impl<'t> Parser<'t> {
    /// Which variable has this name?
    fn variable(&self, name: &str) -> Option<usize> {
        self.variables.iter().position(|variable| variable.name == name)
    }

    fn rest(&self) -> &'t str {
        &self.text[self.at..]
    }

    fn space(&mut self) {
        self.at = self.text.len() - self.rest().trim_start().len();
    }

    fn error(&self, problem: ExpressionProblem) -> ExpressionError {
        let length = self.rest().chars().next().map_or(0, char::len_utf8);
        ExpressionError::in_expression(self.at..self.at + length, problem)
    }

    /// The next character, if it is one of these.
    fn take(&mut self, wanted: &str) -> Option<char> {
        self.space();
        let c = self.rest().chars().next().filter(|c| wanted.contains(*c))?;
        self.at += c.len_utf8();
        Some(c)
    }

    fn sum(&mut self) -> Result<Tree, ExpressionError> {
        let mut left = self.product()?;
        while let Some(c) = self.take("+-") {
            let operator = if c == '+' { Operator::Add } else { Operator::Subtract };
            let right = self.product()?;
            left = binary(operator, left, right);
        }
        Ok(left)
    }

    fn product(&mut self) -> Result<Tree, ExpressionError> {
        let mut left = self.power()?;
        while let Some(c) = self.take("*/") {
            if c == '*' && self.rest().starts_with('*') {
                return Err(self.error(ExpressionProblem::DoubleStar));
            }
            let operator = if c == '*' { Operator::Multiply } else { Operator::Divide };
            let right = self.power()?;
            left = binary(operator, left, right);
        }
        Ok(left)
    }

    fn power(&mut self) -> Result<Tree, ExpressionError> {
        self.depth += 1;
        // Every operator and every call has a power on its right or inside it, so a power stands for two nodes.
        self.nodes += 2;
        if self.nodes > NODES_MAX {
            return Err(self.error(ExpressionProblem::TooLong(NODES_MAX)));
        }
        if self.depth > DEPTH_MAX {
            return Err(self.error(ExpressionProblem::TooDeep));
        }
        self.space();
        let from = self.at;
        let tree = if self.take("-").is_some() {
            let inner = self.power()?;
            Tree { at: from..inner.at.end, node: Node::Negative(Box::new(inner)) }
        } else {
            let base = self.atom()?;
            match self.take("^") {
                Some(_) => {
                    let exponent = self.power()?;
                    let power = constant(&exponent).filter(|power| power.abs() > EXPONENT_MAX);
                    if let Some(power) = power {
                        let problem = ExpressionProblem::ExponentTooLarge(power);
                        return Err(ExpressionError::in_expression(exponent.at, problem));
                    }
                    binary(Operator::Power, base, exponent)
                }
                None => base,
            }
        };
        self.depth -= 1;
        Ok(tree)
    }

    fn atom(&mut self) -> Result<Tree, ExpressionError> {
        self.space();
        let from = self.at;
        match self.rest().chars().next() {
            Some('(') => {
                self.at += 1;
                let inner = self.sum()?;
                self.close(from)?;
                Ok(Tree { node: inner.node, at: from..self.at })
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() || c == '_' => self.name(),
            Some(found) => {
                let expected = Expected::Operand;
                Err(self.error(ExpressionProblem::Unexpected { found, expected }))
            }
            None => Err(self.error(ExpressionProblem::EndsEarly)),
        }
    }

    fn close(&mut self, opened: usize) -> Result<(), ExpressionError> {
        if self.take(")").is_some() {
            return Ok(());
        }
        if self.rest().is_empty() {
            let at = opened..opened + 1;
            return Err(ExpressionError::in_expression(at, ExpressionProblem::OpenParenthesis));
        }
        let found = self.rest().chars().next().unwrap_or(' ');
        let expected = Expected::OperatorOrClose;
        Err(self.error(ExpressionProblem::Unexpected { found, expected }))
    }

    fn number(&mut self) -> Result<Tree, ExpressionError> {
        let from = self.at;
        let digits =
            |text: &str| text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        self.at += digits(self.rest());
        if self.rest().starts_with('.') {
            self.at += 1 + digits(&self.rest()[1..]);
        }
        // An exponent has digits: in 2e, e is not part of the number.
        if let Some(after) = self.rest().strip_prefix(['e', 'E']) {
            let sign = usize::from(after.starts_with(['+', '-']));
            let length = digits(&after[sign..]);
            if length > 0 {
                self.at += 1 + sign + length;
            }
        }
        let text = &self.text[from..self.at];
        let value =
            text.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(|| {
                let problem = ExpressionProblem::NotANumber(text.to_owned());
                ExpressionError::in_expression(from..self.at, problem)
            })?;
        let mut unit = Unit::ONE;
        if self.rest().starts_with('[') {
            let opened = self.at;
            let Some(length) = self.rest().find(']') else {
                let at = opened..opened + 1;
                return Err(ExpressionError::in_expression(at, ExpressionProblem::OpenBracket));
            };
            let inside = &self.rest()[1..length];
            self.at += length + 1;
            unit = Unit::parse(inside)
                .map_err(|problem| ExpressionError::in_expression(opened..self.at, problem))?;
        } else if self.rest().starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
            return Err(self.error(ExpressionProblem::NoOperator));
        }
        Ok(Tree { node: Node::Number(value, unit), at: from..self.at })
    }

    fn name(&mut self) -> Result<Tree, ExpressionError> {
        let from = self.at;
        let part = |c: char| c.is_ascii_alphanumeric() || c == '_';
        self.at += self.rest().len() - self.rest().trim_start_matches(part).len();
        let name = &self.text[from..self.at];
        let at = from..self.at;
        let fail =
            |problem: ExpressionProblem| Err(ExpressionError::in_expression(at.clone(), problem));
        let opened = self.at;
        let called = self.take("(").is_some();
        match (Function::named(name), called) {
            (Some(function), true) => {
                let mut arguments = vec![self.sum()?];
                while self.take(",").is_some() {
                    arguments.push(self.sum()?);
                }
                self.close(opened)?;
                let (takes, found) = (function.arguments(), arguments.len());
                if found != takes {
                    let function = function.name();
                    return fail(ExpressionProblem::Arguments { function, takes, found });
                }
                Ok(Tree { node: Node::Call(function, arguments), at: from..self.at })
            }
            (Some(_), false) => fail(ExpressionProblem::NotCalled(name.to_owned())),
            (None, true) if self.variable(name).is_some() => {
                fail(ExpressionProblem::VariableCalled(name.to_owned()))
            }
            (None, true) => fail(ExpressionProblem::NoFunction {
                name: name.to_owned(),
                functions: Function::NAMES,
            }),
            (None, false) => {
                self.at = opened;
                let node = match (name, self.variable(name)) {
                    (_, Some(variable)) => Node::Variable(variable),
                    ("pi", None) => Node::Number(core::f64::consts::PI, Unit::ONE),
                    _ => Node::Parameter(self.parameter(name, &at)?),
                };
                Ok(Tree { node, at: at.clone() })
            }
        }
    }

    fn parameter(&mut self, name: &str, at: &Range<usize>) -> Result<usize, ExpressionError> {
        if let Some(index) = self.parameters.iter().position(|parameter| parameter == name) {
            return Ok(index);
        }
        let mut names = self.variables.iter().map(|variable| variable.name);
        let slip = names.find(|known| known.len() > 3 && one_slip_apart(known, name));
        let fail = |problem| Err(ExpressionError::in_expression(at.clone(), problem));
        let is_reserved = self.reserved.contains(&name);
        let name = name.to_owned();
        if is_reserved {
            let variables = self.variables.iter().map(|variable| variable.name).collect();
            return fail(ExpressionProblem::Reserved { name, variables });
        }
        if let Some(variable) = slip {
            return fail(ExpressionProblem::LooksLike { name, variable });
        }
        if self.parameters.len() == PARAMETERS_MAX {
            return fail(ExpressionProblem::TooManyParameters { name, most: PARAMETERS_MAX });
        }
        self.parameters.push(name);
        Ok(self.parameters.len() - 1)
    }
}

fn binary(operator: Operator, left: Tree, right: Tree) -> Tree {
    let at = left.at.start..right.at.end;
    Tree { node: Node::Binary(operator, Box::new(left), Box::new(right)), at }
}

/// Whether one letter changed, removed or inserted turns one name into the other.
fn one_slip_apart(a: &str, b: &str) -> bool {
    let same = a.bytes().zip(b.bytes()).take_while(|(a, b)| a == b).count();
    let (a, b) = (&a[same..], &b[same..]);
    match (a.len(), b.len()) {
        (0, 0) => false,
        (m, n) if m == n => a[1..] == b[1..],
        (m, n) if m == n + 1 => &a[1..] == b,
        (m, n) if m + 1 == n => a == &b[1..],
        _ => false,
    }
}
