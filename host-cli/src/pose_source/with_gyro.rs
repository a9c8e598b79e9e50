//! Any source of poses together with a yaw rate sensor that is logged to a file.

use campaign::plan::PlannedRun;
use host_link::Clock;
use host_link::motion::Trigger;
use host_link::wire::Waiting;
use robot_model::calibration::{Deviation, TrackSample};

use super::align::Reckoned;
use super::gyro_log::GyroLog;
use super::{DriveOrSkip, Mark, PoseClock, PoseSource, RunMeasurement, Sigma, YawRate};
use crate::error::Result;

/// A source of poses together with a logged yaw rate sensor.
pub struct WithGyro {
    poses: Box<dyn PoseSource>,
    log: GyroLog,
}

impl WithGyro {
    /// This source together with this log.
    pub fn new(poses: Box<dyn PoseSource>, log: GyroLog) -> Self {
        Self { poses, log }
    }
}

impl PoseSource for WithGyro {
    fn check(&self) -> Result<()> {
        self.poses.check()
    }

    fn place<'a>(
        &'a mut self,
        clock: &'a Clock,
        mark: Mark<'a>,
    ) -> Waiting<'a, Result<DriveOrSkip>> {
        self.poses.place(clock, mark)
    }

    fn begin(&mut self) -> Result<usize> {
        let first = self.poses.begin()?;
        self.log.begin()?;
        Ok(first)
    }

    fn trigger(&self) -> Option<Trigger> {
        self.poses.trigger()
    }

    fn measures_while_driving(&self) -> bool {
        self.poses.measures_while_driving()
    }

    fn pose_count(&self) -> Result<Option<usize>> {
        self.poses.pose_count()
    }

    fn poses_from(&self, first: usize) -> Result<Vec<TrackSample>> {
        self.poses.poses_from(first)
    }

    fn poses_during(&self, first: usize, what: &str) -> Result<Vec<TrackSample>> {
        self.poses.poses_during(first, what)
    }

    fn pose_clock(&self) -> PoseClock {
        self.poses.pose_clock()
    }

    fn noise(&self) -> Option<Sigma> {
        self.poses.noise()
    }

    fn read_deviation<'a>(
        &'a mut self,
        clock: &'a Clock,
        accept: &'a mut dyn FnMut(Deviation) -> Result<()>,
    ) -> Waiting<'a, Result<()>> {
        self.poses.read_deviation(clock, accept)
    }

    fn read_offset<'a>(&'a mut self, clock: &'a Clock) -> Waiting<'a, Result<[f64; 2]>> {
        self.poses.read_offset(clock)
    }

    fn measure<'a>(
        &'a mut self,
        clock: &'a Clock,
        first: usize,
        run: &'a PlannedRun,
        reckoned: &'a [Reckoned],
    ) -> Waiting<'a, Result<RunMeasurement>> {
        self.poses.measure(clock, first, run, reckoned)
    }

    fn reading_sigma(&self) -> Option<Sigma> {
        self.poses.reading_sigma()
    }

    fn yaw_rates(&mut self, run: &str, reckoned: &[Reckoned]) -> Result<Vec<YawRate>> {
        self.log.take(run, reckoned)
    }

    fn is_simulated(&self) -> bool {
        self.poses.is_simulated()
    }
}
