//! The simulator's ruler: reads where the robot is at the end.

use host_link::Clock;
use host_link::wire::Waiting;
use robot_model::calibration::Deviation;
use sim_target::Testbed;

use super::{DriveOrSkip, Mark, PoseSource};
use crate::error::Result;

/// Reads how far the robot is along its start line, and off it.
pub struct Ruler {
    testbed: Testbed,
}

impl Ruler {
    /// The ruler of this testbed.
    pub fn new(testbed: Testbed) -> Self {
        Self { testbed }
    }
}

impl PoseSource for Ruler {
    fn place<'a>(&'a mut self, _: &'a Clock, _: Mark<'a>) -> Waiting<'a, Result<DriveOrSkip>> {
        self.testbed.place_at_start();
        Box::pin(async { Ok(DriveOrSkip::Drive) })
    }

    fn read_deviation<'a>(
        &'a mut self,
        _: &'a Clock,
        accept: &'a mut dyn FnMut(Deviation) -> Result<()>,
    ) -> Waiting<'a, Result<()>> {
        let (y_m, sigma_m) = (self.testbed.read_offset().left_m, self.testbed.ruler_sigma_m());
        let accepted = accept(Deviation::LateralOffset { y_m, sigma_m });
        Box::pin(async { accepted })
    }

    fn read_offset<'a>(&'a mut self, _: &'a Clock) -> Waiting<'a, Result<[f64; 2]>> {
        let reading = self.testbed.read_offset();
        Box::pin(async move { Ok([reading.forward_m, reading.left_m]) })
    }
}
