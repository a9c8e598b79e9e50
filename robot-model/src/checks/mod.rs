//! Checks before any fit: can wheels and poses be of one robot at all?
//!
//! | file | what it holds |
//! | --- | --- |
//! | `units.rs` | a run whose units, counter or clock cannot be right |
//! | `mismatch.rs` | a campaign whose wheels and poses differ by a factor or a sign |
//! | `end_pose.rs` | last poses far from where the wheels led |
//! | `outlier.rs` | last poses that stand alone beside those of all other runs; both together |
//! | `row.rs` | single rows that no robot drove, and headings turned against the way |
//! | `reckoning.rs` | where the wheels alone lead a nominal robot |
//!
//! Thresholds are wide: a robot that is merely wrong passes, as what is wrong with it is for
//! [`crate::explain`] to say.

pub(crate) mod end_pose;
pub(crate) mod mismatch;
pub(crate) mod outlier;
mod reckoning;
pub(crate) mod row;
#[cfg(test)]
mod tests;
pub(crate) mod units;

pub use end_pose::{OffEndPose, beside, doubtful};
pub use mismatch::{Mismatch, mismatch};
pub use outlier::{end_poses_off, misfits};
pub use row::{BadRow, bad_row, crooked};
pub use units::{Suspicion, suspicions};
