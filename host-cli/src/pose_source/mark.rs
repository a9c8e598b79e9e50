//! Where a robot is to be put, and whether it then drives.

use campaign::plan::PlannedRun;

/// Where a robot is to be put.
#[derive(Clone, Copy, Debug)]
pub enum Mark<'a> {
    /// At its line; the words complete the sentence "Put the robot ...".
    Line(&'a str),
    /// At the start of a run of a plan.
    Run(&'a PlannedRun),
}

/// Whether to drive a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveOrSkip {
    /// Drive it.
    Drive,
    /// Skip it this time.
    Skip,
}
