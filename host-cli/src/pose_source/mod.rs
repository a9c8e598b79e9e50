//! What measures where the robot is, and how it gets to its marks: for a calibration, a single run
//! and a whole campaign alike.
//!
//! | source | poses during the run | reading at the end |
//! | --- | --- | --- |
//! | [`camera`] | the simulator's overhead camera | |
//! | [`track_file`] | a tracking system that appends to a file | |
//! | [`ruler`] | | the simulator's ruler |
//! | [`tape`] | | a person with a ruler or a tape |
//! | [`none`] | | |
//! | [`with_gyro`] | one of the others | and a yaw rate sensor that is logged to a file ([`gyro_log`]) |
//!
//! [`mod@bench`] is the testbed of a simulated robot; [`align`] shifts times on another clock to the robot's. What follows from a measurement is left
//! to [`crate::calibrate`] and [`crate::campaign_recorder`].

pub mod align;
pub mod bench;
pub mod camera;
mod confirm;
pub mod gyro_log;
mod mark;
pub mod none;
mod reading;
pub mod ruler;
pub mod tape;
pub mod track_file;
pub mod with_gyro;

use campaign::plan::PlannedRun;
use host_link::Clock;
use host_link::motion::Trigger;
use host_link::wire::Waiting;
use robot_model::calibration::{Deviation, TrackSample};

pub use mark::{DriveOrSkip, Mark};

use self::align::Reckoned;
use crate::error::{Error, Result};

/// The result of measuring a run.
#[derive(Clone, Debug, PartialEq)]
pub enum RunMeasurement {
    /// Poses on the robot's clock; none if nothing was measured.
    Track(Vec<TrackSample>),
    /// The run is to be discarded and driven again.
    Repeat,
    /// The run is to be skipped.
    Skip,
}

/// How well a pose is measured, one sigma.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sigma {
    /// Of x and y \[m\].
    pub position_m: f64,
    /// Of the heading \[rad\].
    pub heading_rad: f64,
}

/// The clock of the poses' times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PoseClock {
    /// The robot's.
    Robot {
        /// The delay of the poses is known, and already subtracted.
        delay_known: bool,
    },
    /// The source's own.
    Own,
}

/// A yaw rate: time on the robot's clock, rate \[s, rad/s\].
pub type YawRate = (f64, f64);

/// A source of poses: measures where the robot is, and has it put at its marks.
pub trait PoseSource {
    /// Refuses, before the robot moves, a source that cannot measure.
    fn check(&self) -> Result<()> {
        Ok(())
    }

    /// Whether a person is asked to put the robot at its marks.
    fn asks_to_place(&self) -> bool {
        false
    }

    /// Has the robot put at a mark.
    fn place<'a>(
        &'a mut self,
        clock: &'a Clock,
        mark: Mark<'a>,
    ) -> Waiting<'a, Result<DriveOrSkip>> {
        let ask = self.asks_to_place();
        Box::pin(async move {
            if ask { confirm::confirm(clock, mark).await } else { Ok(DriveOrSkip::Drive) }
        })
    }

    /// Notes how far the track has come before a run; returns the number of the run's first pose.
    fn begin(&mut self) -> Result<usize> {
        Ok(0)
    }

    /// The trigger of the source, called when a recording begins.
    fn trigger(&self) -> Option<Trigger> {
        None
    }

    /// Whether poses are measured during runs, without asking anybody.
    fn measures_while_driving(&self) -> bool {
        false
    }

    /// How many poses have been measured so far; `None` if none are measured during runs.
    fn pose_count(&self) -> Result<Option<usize>> {
        Ok(None)
    }

    /// The poses from this number on, with times on [`pose_clock`](Self::pose_clock).
    fn poses_from(&self, _first: usize) -> Result<Vec<TrackSample>> {
        Ok(Vec::new())
    }

    /// As [`poses_from`](Self::poses_from), but an error if they are too few for the motion that
    /// `what` names.
    fn poses_during(&self, first: usize, _what: &str) -> Result<Vec<TrackSample>> {
        self.poses_from(first)
    }

    /// The clock of the poses' times.
    fn pose_clock(&self) -> PoseClock {
        PoseClock::Own
    }

    /// The noise of these poses, if it is known.
    fn noise(&self) -> Option<Sigma> {
        None
    }

    /// Reads how far the robot is off its line at the end, until `accept` accepts the reading.
    fn read_deviation<'a>(
        &'a mut self,
        _clock: &'a Clock,
        _accept: &'a mut dyn FnMut(Deviation) -> Result<()>,
    ) -> Waiting<'a, Result<()>> {
        cannot_read()
    }

    /// Reads how far the robot is ahead of its mark, and to the left of it \[m\].
    fn read_offset<'a>(&'a mut self, _clock: &'a Clock) -> Waiting<'a, Result<[f64; 2]>> {
        cannot_read()
    }

    /// Measures a run that has just ended: its poses from `first` on, or the answers of a person.
    fn measure<'a>(
        &'a mut self,
        _clock: &'a Clock,
        _first: usize,
        _run: &'a PlannedRun,
        _reckoned: &'a [Reckoned],
    ) -> Waiting<'a, Result<RunMeasurement>> {
        cannot_read()
    }

    /// The uncertainty of the last run's poses, if a person read them.
    fn reading_sigma(&self) -> Option<Sigma> {
        None
    }

    /// The readings of a yaw rate sensor during the run.
    fn yaw_rates(&mut self, _run: &str, _reckoned: &[Reckoned]) -> Result<Vec<YawRate>> {
        Ok(Vec::new())
    }

    /// Whether the source belongs to the simulator, whose robot is new in each process, with its
    /// clock at zero.
    fn is_simulated(&self) -> bool {
        false
    }
}

/// The error of a source that reads nothing at the end.
fn cannot_read<'a, T: 'a>() -> Waiting<'a, Result<T>> {
    Box::pin(async { Err(Error::new("nothing measures where the robot is at the end")) })
}
