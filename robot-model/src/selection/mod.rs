//! Model selection: which effects does a robot have?
//!
//! | file | what it holds |
//! | --- | --- |
//! | `select.rs` | the search: forward, with exchanges, and back |
//! | `candidates.rs` | every candidate beside a fitted model, from one set of normal equations |
//! | `answers.rs` | what has been asked of a fitted model and its candidates: each question takes a pass over all runs |
//! | `effect_test.rs` | the test of one effect: likelihood, cross-validation, agreement between runs |
//! | `gain.rs` | what is asked about an effect, what it gains, and how uncertain it leaves radii and track width |
//! | `by_kind.rs` | does a kind of run contradict an effect? |
//! | `chance.rs` | may an effect that passes its test be there by chance? |
//! | `dispersion.rs` | by how much more runs disagree about an effect than their noise explains |
//! | `track_gain.rs` | what tracks of other runs gain by an effect, and whether that may be chance |
//! | `classes.rs` | effects that a campaign cannot tell apart |
//!
//! Parameter values come from [`crate::estimation`]. What no effect of the catalogue explains is tested in
//! [`crate::residuals`]. What a user is told is put together in [`crate::explain`].

mod answers;
pub(crate) mod by_kind;
pub(crate) mod candidates;
pub(crate) mod chance;
pub(crate) mod classes;
pub(crate) mod dispersion;
pub(crate) mod effect_test;
pub(crate) mod gain;
pub(crate) mod select;
pub(crate) mod track_gain;
