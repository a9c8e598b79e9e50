//! Expressions that a user writes: `k * v^2 * omega`. How is one read, which units do its parameters have, what is its value?
//!
//! Which variables there are, and what an expression changes, is the caller's: the path's effects
//! ([`crate::effect::custom`]) and the motors' ([`crate::drivetrain::effect`]) have theirs. Every name that is neither a
//! variable nor a function is a free parameter, four at most.
//!
//! | file | what it answers |
//! | --- | --- |
//! | `parse.rs`, `tree.rs` | which tree does a text mean? |
//! | `unit.rs`, `dimensions.rs` | what is a unit, and which ones do the parameters have? |
//! | `amplitudes.rs` | in which parameters is it linear, so that it vanishes without them? |
//! | `evaluate.rs` | what is its value, with derivatives? |
//! | `definition.rs` | what does a user write about an effect of their own, and what follows from it? |
//! | `error.rs` | what is wrong, and where? |

mod amplitudes;
mod definition;
mod dimensions;
mod error;
mod evaluate;
mod parse;
mod tree;
mod unit;

pub(crate) use amplitudes::PLACES;
pub(crate) use definition::{Context, Declared, Sides, check_id, starts};
pub(crate) use dimensions::LeftSide;
pub use error::{
    DefinitionPart, Expected, ExpressionError, ExpressionProblem, RequiredLeftSide, RequiredUnit,
    UnboundedWhen,
};
pub(crate) use evaluate::evaluate;
pub(crate) use parse::parse;
pub(crate) use tree::{Names, Tree, Variable};
pub(crate) use unit::Unit;
