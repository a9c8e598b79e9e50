//! A tracking system that appends poses to a file while the robot drives, by a clock of its own.

use std::path::{Path, PathBuf};

use campaign::live_file::{check_header, track_so_far};
use campaign::plan::PlannedRun;
use host_link::Clock;
use host_link::wire::Waiting;
use robot_model::calibration::TrackSample;

use super::align::{Reckoned, on_robot_clock};
use super::{PoseSource, RunMeasurement, Sigma};
use crate::error::{Error, Result};
use crate::ui;

/// With fewer poses the track is not of the drive.
const POSES_MIN: usize = 10;

/// A file to which a tracking system appends.
pub struct TrackFile {
    /// The file.
    pub path: PathBuf,
    /// The noise of its poses, if it is known.
    pub noise: Option<Sigma>,
    /// Whether to ask a person to put the robot at its mark.
    pub confirm: bool,
}

impl PoseSource for TrackFile {
    fn check(&self) -> Result<()> {
        check_header(&self.path)?.iter().for_each(ui::warn);
        track_so_far(&self.path)?;
        Ok(())
    }

    fn asks_to_place(&self) -> bool {
        self.confirm
    }

    fn begin(&mut self) -> Result<usize> {
        Ok(track_so_far(&self.path)?.len())
    }

    fn measures_while_driving(&self) -> bool {
        true
    }

    fn pose_count(&self) -> Result<Option<usize>> {
        Ok(Some(track_so_far(&self.path)?.len()))
    }

    fn poses_from(&self, first: usize) -> Result<Vec<TrackSample>> {
        Ok(track_so_far(&self.path)?.get(first..).unwrap_or_default().to_vec())
    }

    fn poses_during(&self, first: usize, what: &str) -> Result<Vec<TrackSample>> {
        let poses = self.poses_from(first)?;
        if poses.len() < POSES_MIN {
            return Err(Error::new(format_args!(
                "{} got {} samples during the {what}",
                self.path.display(),
                poses.len()
            ))
            .hint("is the tracking system running, and does it append to this file?"));
        }
        Ok(poses)
    }

    fn noise(&self) -> Option<Sigma> {
        self.noise
    }

    fn measure<'a>(
        &'a mut self,
        _: &'a Clock,
        first: usize,
        run: &'a PlannedRun,
        reckoned: &'a [Reckoned],
    ) -> Waiting<'a, Result<RunMeasurement>> {
        Box::pin(async move {
            let poses = self.poses_during(first, &format!("run {}", run.name))?;
            let track = on_robot_clock(poses, reckoned).ok_or_else(|| no_shift(&self.path))?;
            Ok(RunMeasurement::Track(track))
        })
    }
}

/// The error of a track that is of another run or robot.
pub(super) fn no_shift(path: &Path) -> Error {
    Error::new(format_args!("{} and the wheels do not show the same motion", path.display()))
        .hint("is it the track of this run and this robot?")
}
