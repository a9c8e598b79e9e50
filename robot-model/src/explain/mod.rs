//! What is missing from a model, what cannot be told apart, what stays unexplained, and which run to make next.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `explanation.rs` | [`explain`]: effects found, in order of evidence, and effects rejected |
//! | `answer.rs` | [`Answer`]: what it answers |
//! | `next_run.rs` | the cheapest run that would tell rivals apart |
//! | [`model`] | a model that somebody chose, fitted and tested |
//! | `held_out.rs` | errors on the runs kept aside (`held_out = true`) |
//!
//! The search is in [`crate::selection`], the tests of what is left over in [`crate::residuals`].

pub(crate) mod answer;
pub(crate) mod explanation;
pub(crate) mod held_out;
pub mod model;
pub(crate) mod next_run;
#[cfg(test)]
mod tests;

pub use answer::{
    Answer, HeldOut, NextRun, ParameterFound, PlanKind, Promise, Reason, Rejected, StepFound, Why,
};
pub use explanation::{explain, explain_beyond, explain_by};
pub use next_run::{Plan, plans};
