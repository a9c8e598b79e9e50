//! An expression as a tree in which every node has its place in the text.

use core::ops::Range;

use super::unit::Unit;

/// A node, with its place in the text in bytes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tree {
    pub node: Node,
    pub at: Range<usize>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Node {
    Number(f64, Unit),
    Variable(Variable),
    Parameter(usize),
    Negative(Box<Tree>),
    Binary(Operator, Box<Tree>, Box<Tree>),
    Call(Function, Vec<Tree>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

macro_rules! names {
    ($(#[$doc:meta])* $kind:ident { $($variant:ident = $name:literal),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(super) enum $kind { $($variant),* }

        impl $kind {
            pub const NAMES: &[&str] = &[$($name),*];

            pub fn named(name: &str) -> Option<Self> {
                match name { $($name => Some(Self::$variant),)* _ => None }
            }
        }
    };
}

names! {
    /// The variables of a step.
    Variable {
        V = "v", Omega = "omega", VLeft = "v_left", VRight = "v_right", A = "a", ALeft = "a_left",
        ARight = "a_right", Theta = "theta", PhiLeft = "phi_left", PhiRight = "phi_right", S = "s",
        T = "t", TRun = "t_run", Payload = "payload",
    }
}

names! {
    /// The functions of an expression.
    Function {
        Sin = "sin", Cos = "cos", Tan = "tan", Exp = "exp", Ln = "ln", Sqrt = "sqrt", Tanh = "tanh",
        Abs = "abs", Sign = "sign", Min = "min", Max = "max",
    }
}

impl Function {
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    pub fn arguments(self) -> usize {
        if matches!(self, Self::Min | Self::Max) { 2 } else { 1 }
    }
}
