//! Which campaigns pass the checks, and which do not.

mod end_pose;
mod mismatch;
mod units;
