//! Checks before any fit: can wheels and poses be of one robot at all?
//!
//! | file | what it holds |
//! | --- | --- |
//! | `units.rs` | a run with wrong units, a counter that overflows or a wrong clock |
//! | `mismatch.rs` | a campaign whose wheels and poses differ by a factor or a sign |
//! | `end_pose.rs` | last poses far from where the wheels led |
//! | `outlier.rs` | last poses that are outliers among all runs; both together |
//! | `row.rs` | single impossible rows, and headings that point away from the direction of travel |
//! | `dead_reckoning.rs` | dead reckoning of a nominal robot |
//!
//! Thresholds are wide: a robot that is merely inaccurate passes, and [`crate::explain`] finds out why.

mod dead_reckoning;
pub(crate) mod end_pose;
pub(crate) mod mismatch;
pub(crate) mod outlier;
pub(crate) mod row;
#[cfg(test)]
mod tests;
pub(crate) mod units;

pub use end_pose::{OffEndPose, implausible_end_pose, median_pose_error};
pub use mismatch::{Mismatch, mismatch};
pub use outlier::{end_pose_misfits, end_poses_off};
pub use row::{BadRow, bad_row, heading_offset};
pub use units::{Suspicion, suspicions};
