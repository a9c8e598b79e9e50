//! The simulator's testbed as a source of poses: its overhead camera and its gyro. The robot is
//! carried to its marks without asking anybody.

use std::rc::Rc;
use std::time::Duration;

use campaign::plan::PlannedRun;
use host_link::Clock;
use host_link::motion::Trigger;
use host_link::wire::Waiting;
use robot_model::calibration::TrackSample;
use sim_target::Testbed;
use sim_target::plant::Pose;

use super::align::Reckoned;
use super::bench::Bench;
use super::{DriveOrSkip, Mark, PoseClock, PoseSource, RunMeasurement, Sigma, YawRate};
use crate::error::Result;

/// How long it takes to carry the robot to the mark of a run.
const CARRY: Duration = Duration::from_secs(10);
const CARRY_REAL: Duration = Duration::from_secs(1);

/// The simulator's camera.
pub struct Camera {
    bench: Bench,
    /// The number of readings of the yaw rate sensor before the run.
    rates_before: usize,
}

impl Camera {
    /// The camera of this testbed.
    pub fn new(bench: impl Into<Bench>) -> Self {
        Self { bench: bench.into(), rates_before: 0 }
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
                Mark::Line(_) => self.bench.with(Testbed::place_at_start)?,
                Mark::Run(run) => {
                    // Somebody looks on where the time is real.
                    let carry = if clock.is_virtual() { CARRY } else { CARRY_REAL };
                    clock.sleep(carry).await;
                    let (payload_kg, heading_rad) = (run.payload_kg, run.heading_rad);
                    self.bench.with(move |testbed| {
                        testbed.set_payload(payload_kg);
                        testbed.place_on(Pose { heading_rad, ..Pose::default() });
                    })?;
                }
            }
            Ok(DriveOrSkip::Drive)
        })
    }

    fn begin(&mut self) -> Result<usize> {
        self.rates_before = self.bench.with(Testbed::gyro_len)?;
        self.bench.with(Testbed::camera_len)
    }

    fn trigger(&self) -> Option<Trigger> {
        let bench = self.bench.clone();
        Some(Rc::new(move |t_us| {
            // Without the trigger, its pictures have other times: nothing is lost.
            let _ = bench.with(move |testbed| testbed.trigger_camera(t_us));
        }))
    }

    fn measures_while_driving(&self) -> bool {
        true
    }

    fn pose_count(&self) -> Result<Option<usize>> {
        Ok(Some(self.bench.with(Testbed::camera_len)?))
    }

    fn poses_from(&self, first: usize) -> Result<Vec<TrackSample>> {
        let pose = |sample: sim_target::instruments::CameraSample| TrackSample {
            t_s: sample.t_s,
            x_m: sample.x_m,
            y_m: sample.y_m,
            heading_rad: Some(sample.heading_rad),
        };
        let samples = self.bench.with(move |testbed| testbed.camera_samples_from(first))?;
        Ok(samples.into_iter().map(pose).collect())
    }

    fn pose_clock(&self) -> PoseClock {
        let delay_known = self.bench.with(|testbed| testbed.camera_parameters().delay_known);
        PoseClock::Robot { delay_known: delay_known.unwrap_or(false) }
    }

    fn noise(&self) -> Option<Sigma> {
        let parameters = self.bench.with(Testbed::camera_parameters).ok()?;
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
        let before = self.rates_before;
        let readings = self.bench.with(move |testbed| testbed.gyro_samples_from(before))?;
        Ok(readings.into_iter().map(|reading| (reading.t_s, reading.yaw_rate_rad_s)).collect())
    }

    fn is_simulated(&self) -> bool {
        self.bench.is_own()
    }
}
