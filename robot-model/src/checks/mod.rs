//! Checks before any fit: is something wrong with the data, and not with the robot?
//!
//! Each thing that can be wrong is a hypothesis ([`DataFault`]): a transformation of the recording that would mend it. Each
//! is fitted to the tracks. The start pose of every run and the lateness of its poses are free; so are, within limits, a
//! radius, a ratio of radii and a track width of the robot. The best one is reported where it beats the data as they are by
//! a factor of three and leaves no run far off. Positions alone suffice.
//!
//! ```text
//! recordings --counters--> wheels --fit geometry--tracker--> tracks --fit geometry--> all in order? nothing is reported
//!                                                                         | far off
//!                             all runs alike: each hypothesis with a geometry of its own
//!                             one run: each hypothesis by the geometry of the others; its last pose
//! ```
//!
//! | file | what it holds |
//! | --- | --- |
//! | `data_fault.rs` | [`DataFault`]: what can be wrong; [`DataHypothesis`]: that with its evidence |
//! | `hypotheses.rs` | [`data_hypotheses`]: everything together |
//! | `all_runs.rs`, `one_run.rs` | which hypothesis explains all runs, or one |
//! | `constant_factor.rs` | whether a wheel counts wrongly by one factor throughout a run, or slips |
//! | `counters.rs`, `tracker.rs` | what happens at a moment: wraps, resets, jumps, repeated values |
//! | `thinned_run.rs`, `start_pose_fit.rs`, `relative_geometry.rs`, `geometry_fit.rs` | a thinned run; its start pose by least squares; a geometry relative to the data sheet; that of all runs |
//! | `last_pose.rs`, `end_pose.rs` | last poses that were misread |
//! | `position_outliers.rs` | single positions far from their neighbours |
//! | `heading_marker.rs` | headings turned by a small angle in all runs |
//! | `dead_reckoning.rs` | where the wheels alone lead a nominal robot |
//! | `clock.rs` | a clock that is not in seconds |
//!
//! Thresholds are wide: a robot that is merely inaccurate passes, and [`crate::explain`] finds out why.

mod all_runs;
mod clock;
mod constant_factor;
mod counters;
mod data_fault;
mod dead_reckoning;
mod end_pose;
mod geometry_fit;
mod heading_marker;
mod hypotheses;
mod last_pose;
mod one_run;
mod position_outliers;
mod relative_geometry;
mod start_pose_fit;
#[cfg(test)]
mod tests;
mod thinned_run;
mod tracker;

pub use clock::{ClockJump, SlowClock, clock_jump, slow_clock};
pub use data_fault::{Axes, DataFault, DataHypothesis, Wheel};
pub use end_pose::{OffEndPose, implausible_end_pose};
pub use heading_marker::heading_offset;
pub use hypotheses::data_hypotheses;
pub use position_outliers::{Spike, outliers_s, spike};
