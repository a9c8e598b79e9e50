//! No source of poses: they are added to the files later.

use campaign::plan::PlannedRun;
use host_link::Clock;
use host_link::wire::Waiting;

use super::align::Reckoned;
use super::{PoseSource, RunMeasurement};
use crate::error::Result;

/// No source of poses.
pub struct NoPoses {
    /// Whether to ask before each run.
    pub confirm: bool,
}

impl PoseSource for NoPoses {
    fn asks_to_place(&self) -> bool {
        self.confirm
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
