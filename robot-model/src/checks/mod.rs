//! Checks before any fit: is something wrong with the data, and not with the robot?
//!
//! Each thing that can be wrong is a hypothesis ([`What`]): a transformation of the recording that would mend it. Each
//! is fitted to the tracks, with the start pose of every run free, how late its poses are, and within limits a radius,
//! a ratio of radii and a track width of the robot. The best one is told where it beats the data as they are by
//! a factor of three and leaves no run far off. Positions alone suffice.
//!
//! ```text
//! recordings --counters--> wheels --fit geometry--tracker--> tracks --fit geometry--> all in order? nothing is told
//!                                                                         | far off
//!                             all runs alike: each hypothesis with a geometry of its own
//!                             one run: each hypothesis by the geometry of the others; its last pose
//! ```
//!
//! | file | what it holds |
//! | --- | --- |
//! | `what.rs` | [`What`] can be wrong, and [`DataHypothesis`]: that with its evidence |
//! | `hypotheses.rs` | [`data_hypotheses`]: everything together |
//! | `all_runs.rs`, `one_run.rs` | which hypothesis explains all runs, or one |
//! | `counters.rs`, `tracker.rs` | what happens at a moment: wraps, resets, jumps, repeated values |
//! | `track.rs`, `fit.rs`, `geometry.rs`, `solve.rs` | a thinned run; its least squares; a geometry; that of all runs |
//! | `last_pose.rs`, `end_pose.rs` | last poses that were misread |
//! | `row.rs`, `dead_reckoning.rs` | single positions that are elsewhere; a crooked heading marker |
//! | `clock.rs` | a clock that is not in seconds |
//!
//! Thresholds are wide: a robot that is merely inaccurate passes, and [`crate::explain`] finds out why.

mod all_runs;
mod clock;
mod counters;
mod dead_reckoning;
mod end_pose;
mod fit;
mod geometry;
mod hypotheses;
mod last_pose;
mod one_run;
mod row;
mod solve;
#[cfg(test)]
mod tests;
mod track;
mod tracker;
mod what;

pub use clock::{SlowClock, slow_clock};
pub use end_pose::{OffEndPose, implausible_end_pose};
pub use hypotheses::data_hypotheses;
pub use row::{Spike, heading_offset, spike};
pub use what::{Axes, DataHypothesis, What, Wheel};
