//! Which campaigns pass the checks, and which do not.

mod clock;
mod end_pose;
mod hypotheses;
mod mutations;
mod slip;
