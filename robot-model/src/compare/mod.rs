//! Predicted against measured: how far apart, where, and how much of it is noise.
//!
//! Two views of the same thing:
//!
//! - *whole runs*: the model drives each run blindly from its best start; what it is off by then, in
//!   millimetres and milliradians, is what a user of its odometry would see ([`RunCompared`]). What noise
//!   alone would give is found by driving the same run again and again with made-up noise.
//! - *stretches*: an error grows along the way and stays, so a whole run does not tell where it came from.
//!   Every run is cut where a regime changes (from ramp to cruise, from forward to backward); over each
//!   stretch the measured move is compared with the predicted one ([`Cell`]). Noise is then known by
//!   formula, and what is the same in all stretches of a regime is systematic.
//!
//! What is noise was found with every known effect free at once, so that no effect passes for noise.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `comparison.rs` | [`Comparer`]: a campaign with its noise, and [`Comparison`] with a model |
//! | `driven.rs` | whole runs |
//! | `stretch.rs`, `regime.rs` | stretches, and their errors by regime |
//! | `curve.rs` | what is left against speed, heading, load and time |
//! | `finding.rs` | the main finding |
//! | `rms.rs` | a root mean square beside that of noise |
//!
//! Which effect is behind an error is not asked here: that is [`crate::explain`].

pub(crate) mod comparison;
mod curve;
mod driven;
mod finding;
mod regime;
mod rms;
mod stretch;
#[cfg(test)]
mod tests;

pub use comparison::{Assumed, Comparer, Comparison};
pub use curve::{Axis, Bin, Curve};
pub use driven::{Path, RunCompared};
pub use finding::{Extent, Finding, Worst};
pub use regime::{Cell, Label, Question, Regime};
pub use rms::Rms;
pub use stretch::{Aspect, Drift};
