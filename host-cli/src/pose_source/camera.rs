//! The simulator's testbed as a source of poses: its overhead camera and its gyro. The robot is
//! carried to its marks without asking anybody.

use std::time::Duration;

use campaign::plan::PlannedRun;
use host_link::Clock;
use host_link::motion::Trigger;
use host_link::wire::Waiting;
use robot_model::calibration::TrackSample;
use sim_target::Testbed;
use sim_target::plant::Pose;

use super::align::Reckoned;
use super::{DriveOrSkip, Mark, PoseClock, PoseSource, RunMeasurement, Sigma, YawRate};
use crate::error::Result;

/// How long it takes to carry the robot to the mark of a run.
const CARRY: Duration = Duration::from_secs(10);

/// The simulator's camera.
pub struct Camera {
    testbed: Testbed,
    /// The number of readings of the yaw rate sensor before the run.
    rates_before: usize,
}

impl Camera {
    /// The camera of this testbed.
    pub fn new(testbed: Testbed) -> Self {
        Self { testbed, rates_before: 0 }
    }
}

impl PoseSource for Camera {
    fn place<'a>(
        &'a mut self,
        clock: &'a Clock,
        mark: Mark<'a>,
    ) -> Waiting<'a, Result<DriveOrSkip>> {
        Box::pin(async move {
            match mark {
                Mark::Line(_) => self.testbed.place_at_start(),
                Mark::Run(run) => {
                    clock.sleep(CARRY).await;
                    self.testbed.set_payload(run.payload_kg);
                    self.testbed.place_on(Pose { heading_rad: run.heading_rad, ..Pose::default() });
                }
            }
            Ok(DriveOrSkip::Drive)
        })
    }

    fn begin(&mut self) -> Result<usize> {
        self.rates_before = self.testbed.gyro_len();
        Ok(self.testbed.camera_len())
    }

    fn trigger(&self) -> Option<Trigger> {
        Some(sim_link::camera_trigger(self.testbed.clone()))
    }

    fn measures_while_driving(&self) -> bool {
        true
    }

    fn pose_count(&self) -> Result<Option<usize>> {
        Ok(Some(self.testbed.camera_len()))
    }

    fn poses_from(&self, first: usize) -> Result<Vec<TrackSample>> {
        let pose = |sample: sim_target::instruments::CameraSample| TrackSample {
            t_s: sample.t_s,
            x_m: sample.x_m,
            y_m: sample.y_m,
            heading_rad: Some(sample.heading_rad),
        };
        Ok(self.testbed.camera_samples_from(first).into_iter().map(pose).collect())
    }

    fn pose_clock(&self) -> PoseClock {
        PoseClock::Robot { delay_known: self.testbed.camera_parameters().delay_known }
    }

    fn noise(&self) -> Option<Sigma> {
        let parameters = self.testbed.camera_parameters();
        let (position_m, heading_rad) = (parameters.position_sigma_m, parameters.heading_sigma_rad);
        Some(Sigma { position_m, heading_rad })
    }

    fn measure<'a>(
        &'a mut self,
        _: &'a Clock,
        first: usize,
        _: &'a PlannedRun,
        _: &'a [Reckoned],
    ) -> Waiting<'a, Result<RunMeasurement>> {
        Box::pin(async move { self.poses_from(first).map(RunMeasurement::Track) })
    }

    fn yaw_rates(&mut self, _: &str, _: &[Reckoned]) -> Result<Vec<YawRate>> {
        let readings = self.testbed.gyro_samples_from(self.rates_before).into_iter();
        Ok(readings.map(|reading| (reading.t_s, reading.yaw_rate_rad_s)).collect())
    }

    fn is_simulated(&self) -> bool {
        true
    }
}
