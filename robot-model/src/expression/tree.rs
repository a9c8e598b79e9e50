//! An expression as a tree in which every node has its place in the text.

use core::ops::Range;

use super::unit::Unit;

/// A node, with its place in the text in bytes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tree {
    pub node: Node,
    pub at: Range<usize>,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Node {
    Number(f64, Unit),
    /// By its place in the list that was given to the parser.
    Variable(usize),
    Parameter(usize),
    Negative(Box<Tree>),
    Binary(Operator, Box<Tree>, Box<Tree>),
    Call(Function, Vec<Tree>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

/// What an expression may use by name, besides its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Variable {
    pub name: &'static str,
    pub unit: Unit,
}

impl Variable {
    /// A variable whose unit has these powers of metre, second, kilogram and volt.
    pub const fn new(name: &'static str, unit: [f64; 4]) -> Self {
        Self { name, unit: Unit(unit) }
    }

    /// The variables of a table that has something of each beside it.
    pub const fn of_table<Beside, const LEN: usize>(table: &[(Self, Beside); LEN]) -> [Self; LEN] {
        let mut variables = [table[0].0; LEN];
        let mut index = 0;
        while index < LEN {
            variables[index] = table[index].0;
            index += 1;
        }
        variables
    }
}

/// Names with a meaning.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Names {
    pub variables: &'static [Variable],
    /// What means something elsewhere, and would be a misleading name for a parameter.
    pub reserved: &'static [&'static str],
}

macro_rules! functions {
    ($($variant:ident = $name:literal),* $(,)?) => {
        /// The functions of an expression.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Function { $($variant),* }

        impl Function {
            pub const NAMES: &[&str] = &[$($name),*];

            pub fn named(name: &str) -> Option<Self> {
                match name { $($name => Some(Self::$variant),)* _ => None }
            }
        }
    };
}

functions! {
    Sin = "sin", Cos = "cos", Tan = "tan", Exp = "exp", Ln = "ln", Sqrt = "sqrt", Tanh = "tanh",
    Abs = "abs", Sign = "sign", Min = "min", Max = "max",
}

impl Function {
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    pub fn arguments(self) -> usize {
        if matches!(self, Self::Min | Self::Max) { 2 } else { 1 }
    }
}
