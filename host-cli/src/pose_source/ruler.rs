//! The simulator's ruler: reads where the robot is at the end.

use host_link::Clock;
use host_link::wire::Waiting;
use robot_model::calibration::Deviation;
use sim_target::Testbed;

use super::bench::Bench;
use super::{DriveOrSkip, Mark, PoseSource};
use crate::error::Result;

/// Reads how far the robot is along its start line, and off it.
pub struct Ruler {
    bench: Bench,
}

impl Ruler {
    /// The ruler of this testbed.
    pub fn new(bench: impl Into<Bench>) -> Self {
        Self { bench: bench.into() }
    }
}

impl PoseSource for Ruler {
    fn place<'a>(&'a mut self, _: &'a Clock, _: Mark<'a>) -> Waiting<'a, Result<DriveOrSkip>> {
        let placed = self.bench.with(Testbed::place_at_start);
        Box::pin(async { placed.map(|()| DriveOrSkip::Drive) })
    }

    fn read_deviation<'a>(
        &'a mut self,
        _: &'a Clock,
        accept: &'a mut dyn FnMut(Deviation) -> Result<()>,
    ) -> Waiting<'a, Result<()>> {
        let read =
            self.bench.with(|testbed| (testbed.read_offset().left_m, testbed.ruler_sigma_m()));
        let accepted =
            read.and_then(|(y_m, sigma_m)| accept(Deviation::LateralOffset { y_m, sigma_m }));
        Box::pin(async { accepted })
    }

    fn read_offset<'a>(&'a mut self, _: &'a Clock) -> Waiting<'a, Result<[f64; 2]>> {
        let reading = self.bench.with(Testbed::read_offset);
        Box::pin(async { reading.map(|reading| [reading.forward_m, reading.left_m]) })
    }
}
