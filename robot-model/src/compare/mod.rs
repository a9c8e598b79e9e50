//! How far is a model off, where, and how much of that is noise?
//!
//! Predicted and measured poses are compared in two ways:
//!
//! - *whole runs*: the model predicts each run open loop from its best start. The error, in millimetres and
//!   milliradians, is the one that a user of its odometry would see ([`RunCompared`]). The share of noise is found
//!   by simulating the same run many times with drawn noise.
//! - *stretches*: an error grows along the path and stays, so a whole run does not tell where it arose.
//!   Every run is cut where a regime changes (from ramp to cruise, from forward to backward). Over each
//!   stretch the measured move is compared with the predicted one ([`RegimeError`]). Its noise is known in closed
//!   form, and what is the same in all stretches of a regime is systematic.
//!
//! The noise is estimated with every effect that `explain` accepts in the model, so that no effect passes for noise.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `comparison.rs` | [`Comparer`]: a campaign with its noise, and [`Comparison`] with a model |
//! | `whole_runs.rs`, `simulated_run.rs` | whole runs, and their simulation with noise alone |
//! | `stretch.rs`, `regime.rs` | stretches, and their errors by regime |
//! | `curve.rs` | residuals against speed, heading, wheel angle and time |
//! | `finding.rs` | the main finding |
//! | `rms.rs` | a root mean square beside that of noise |
//!
//! Which effect causes an error is a question for [`crate::explain`].

pub(crate) mod comparison;
mod curve;
mod finding;
mod regime;
mod rms;
mod simulated_run;
mod stretch;
#[cfg(test)]
mod tests;
mod whole_runs;

pub use comparison::{Comparer, Comparison, EffectWithValues};
pub use curve::{Axis, Bin, Curve};
pub use finding::{ErrorLevel, Finding, WorstGroup};
pub use regime::{Grouping, Label, Regime, RegimeError};
pub use rms::Rms;
pub use stretch::{Component, Drift};
pub use whole_runs::{Path, RunCompared, RunPredicted};
