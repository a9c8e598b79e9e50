//! Why can an expression not be used? What is wrong, and where; the sentences are the caller's.

use core::fmt;
use core::ops::Range;

/// Which part of the definition of a user's own effect is wrong.
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

/// What is wrong.
#[derive(Clone, Debug, PartialEq)]
pub enum ExpressionProblem {
    /// An id that has other characters than small letters, digits and `_`, or that an effect of the catalogue has.
    Id(String),
    /// No `=` in the equation.
    NoEquals,
    /// The left-hand side is nothing that an effect can change.
    Target(String),
    /// A unit or a range of a parameter that the expression does not have.
    NoParameter {
        /// Its name.
        name: String,
        /// The parameters that the expression has.
        parameters: Vec<String>,
    },
    /// Ends in the wrong order or not finite, or an amplitude's without zero between them.
    Range {
        /// The parameter.
        name: String,
        /// The range.
        range: [f64; 2],
        /// Whether zero must lie within.
        of_amplitude: bool,
    },
    /// Nothing plausible follows from the expression for this parameter.
    NoPlausibleValue(String),
    /// The effect does not vanish when all its parameters are zero.
    DoesNotVanish,
    /// It grows without bound in this motion.
    Unbounded(UnboundedWhen),
    /// An exponent that no quantity has.
    ExponentTooLarge(f64),
    /// Not a unit.
    NotAUnit(String),
    /// A unit, but not made of metre, second, kilogram, volt and radian.
    NotAnSiBaseUnit(String),
    /// A unit where another one, or none, is required.
    WrongUnit {
        /// What is required.
        required: RequiredUnit,
        /// By which unit it is wrong, as a factor.
        factor: String,
    },
    /// The unit of this parameter does not follow from the expression.
    UnknownUnit(String),
    /// A character that cannot stand here.
    Unexpected {
        /// The character.
        found: char,
        /// What can.
        expected: Expected,
    },
    /// The expression ends where an operand is required.
    EndsEarly,
    /// A parenthesis that closes nothing.
    ClosesNothing,
    /// A parenthesis that is not closed.
    OpenParenthesis,
    /// A bracket that is not closed.
    OpenBracket,
    /// `**`.
    DoubleStar,
    /// A factor without its operator.
    NoOperator,
    /// Not a finite number.
    NotANumber(String),
    /// More than this many numbers, names and operators.
    TooLong(usize),
    /// Parentheses nested too deep.
    TooDeep,
    /// A function with the wrong number of arguments.
    Arguments {
        /// The function.
        function: &'static str,
        /// How many it takes.
        takes: usize,
        /// How many are there.
        found: usize,
    },
    /// A function without its arguments.
    NotCalled(String),
    /// A variable with arguments.
    VariableCalled(String),
    /// No such function.
    NoFunction {
        /// The name.
        name: String,
        /// Those that there are.
        functions: &'static [&'static str],
    },
    /// A parameter whose name is one letter away from a variable's.
    LooksLike {
        /// The name.
        name: String,
        /// The variable.
        variable: &'static str,
    },
    /// A parameter with a name that means something elsewhere.
    Reserved {
        /// The name.
        name: String,
        /// The variables that there are here.
        variables: Vec<&'static str>,
    },
    /// One parameter too many.
    TooManyParameters {
        /// Its name.
        name: String,
        /// The most that can be fitted.
        most: usize,
    },
}

/// A motion in which an expression may grow without bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnboundedWhen {
    /// Speed and turn rate go to zero.
    AtRest,
    /// The accelerations go to zero.
    AtConstantSpeed,
    /// The voltages go to zero.
    WithoutVoltage,
}

/// Which unit is required.
#[derive(Clone, Debug, PartialEq)]
pub enum RequiredUnit {
    /// The whole expression: that of its left-hand side.
    LeftSide(Box<RequiredLeftSide>),
    /// The argument of this function: none.
    Argument(&'static str),
    /// An exponent: none.
    Exponent,
    /// The base of a power with a variable exponent: none.
    Base,
    /// Two operands: the same.
    Same,
}

/// The left-hand side of an equation, as what its right-hand side must have the unit of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RequiredLeftSide {
    /// What changes.
    pub quantity: &'static str,
    /// Per what, if it is a rate.
    pub per: Option<&'static str>,
    /// Its unit.
    pub unit: String,
}

/// What can stand at a place of an expression.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// An operator.
    Operator,
    /// An operator, or a parenthesis that closes.
    OperatorOrClose,
    /// A number, a variable, a parameter or a parenthesis that opens.
    Operand,
}

/// Why an expression cannot be used, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpressionError {
    /// Which part is wrong.
    pub part: DefinitionPart,
    /// Where in that part, in bytes.
    pub at: Range<usize>,
    /// What is wrong.
    pub problem: ExpressionProblem,
}

impl ExpressionError {
    pub(crate) const fn new(
        part: DefinitionPart,
        at: Range<usize>,
        problem: ExpressionProblem,
    ) -> Self {
        Self { part, at, problem }
    }

    pub(crate) const fn in_expression(at: Range<usize>, problem: ExpressionProblem) -> Self {
        Self::new(DefinitionPart::Expression, at, problem)
    }
}

impl fmt::Display for ExpressionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { part, at, problem } = self;
        write!(f, "{part:?} at {at:?}: {problem:?}")
    }
}

impl core::error::Error for ExpressionError {}
