//! Which effects are missing, which cannot be told apart, what stays unexplained, and which run to drive next?
//!
//! | file | what it holds |
//! | --- | --- |
//! | `explanation.rs` | [`explain`]: effects found, in order of evidence, and effects rejected |
//! | `model_choice.rs` | the choice of effects, by a noise estimate that no missing effect inflates |
//! | `used_to_predict.rs` | which of the effects found predict other runs |
//! | `model_averaging.rs` | what predicts other runs: each class by all its members |
//! | `model_errors.rs` | the errors of a model |
//! | `parameters.rs` | values and intervals |
//! | `progress.rs` | [`Progress`]: what was found so far |
//! | `reachable_error.rs` | what any model could reach, how far above it the error is, an equation for the rest |
//! | `quiet_runs.rs` | the same, where some runs are off by far more than the others |
//! | `set_aside.rs` | a few runs that are off are left out, where they hide what the others show |
//! | `answer.rs` | [`Answer`]: verdicts and numbers |
//! | `next_run.rs` | the cheapest run that would tell rivals apart |
//! | [`model`] | a model whose effects the user chose, fitted and tested |
//! | `alternative_fit.rs` | radii and track width alone, or least squares of whole tracks, where these predict better |
//! | `held_out.rs` | errors on held-out runs (`held_out = true`) |
//!
//! The search for effects is in `selection`, the tests of the residuals are in [`crate::residuals`].

pub(crate) mod alternative_fit;
pub(crate) mod answer;
pub(crate) mod explanation;
pub(crate) mod held_out;
pub mod model;
pub(crate) mod model_averaging;
pub(crate) mod model_choice;
pub(crate) mod model_errors;
pub(crate) mod next_run;
pub(crate) mod parameters;
pub(crate) mod progress;
pub(crate) mod quiet_runs;
pub(crate) mod reachable_error;
pub(crate) mod set_aside;
#[cfg(test)]
mod tests;
pub(crate) mod used_to_predict;

pub use answer::{
    Answer, Averaged, CandidateKind, Evidence, HeldOut, NextRun, ParameterFound,
    PredictedSeparation, Reason, Rejected, StepFound,
};
pub use explanation::{explain, explain_given, explain_observed, explain_with};
pub use next_run::{CandidateRun, candidate_runs};
pub use progress::{Observer, Progress};
