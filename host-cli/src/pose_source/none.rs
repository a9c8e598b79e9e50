//! No source of poses: they are added to the files later.

use campaign::plan::PlannedRun;
use host_link::Clock;
use host_link::wire::Waiting;

use super::align::Reckoned;
use super::confirm::confirm;
use super::{DriveOrSkip, Mark, PoseSource, RunMeasurement};
use crate::error::Result;

/// No source of poses.
pub struct NoPoses {
    /// Whether to ask before each run.
    pub confirm: bool,
}

impl PoseSource for NoPoses {
    fn place<'a>(
        &'a mut self,
        clock: &'a Clock,
        mark: Mark<'a>,
    ) -> Waiting<'a, Result<DriveOrSkip>> {
        Box::pin(async move {
            if self.confirm { confirm(clock, mark).await } else { Ok(DriveOrSkip::Drive) }
        })
    }

    fn measure<'a>(
        &'a mut self,
        _: &'a Clock,
        _: usize,
        _: &'a PlannedRun,
        _: &'a [Reckoned],
    ) -> Waiting<'a, Result<RunMeasurement>> {
        Box::pin(async { Ok(RunMeasurement::Track(Vec::new())) })
    }
}
