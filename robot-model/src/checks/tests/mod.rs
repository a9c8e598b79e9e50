//! What passes and what does not.

mod end_pose;
mod mismatch;
mod units;
