//! What measures where the robot is, and who puts it at its marks: for a calibration, a single run and a whole
//! campaign alike.
//!
//! | source | sees the robot on its way | is asked at the end |
//! | --- | --- | --- |
//! | [`camera`] | the simulator's overhead camera | |
//! | [`track_file`] | a tracking system that appends to a file | |
//! | [`ruler`] | | the simulator's ruler |
//! | [`tape`] | | a person with a ruler or a tape |
//! | [`nobody`] | | |
//! | [`with_gyro`] | one of the others | and a yaw rate sensor that is logged to a file ([`gyro_log`]) |
//!
//! [`align`] brings a clock of their own to the robot's. What follows from a measurement is left to
//! [`crate::calibrate`] and [`crate::survey`].

pub mod align;
pub mod camera;
mod confirm;
pub mod gyro_log;
pub mod nobody;
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

use self::align::Reckoned;
use crate::error::{Error, Result};

/// Where a robot is to be put.
#[derive(Clone, Copy, Debug)]
pub enum Mark<'a> {
    /// At its line, as these words say.
    Line(&'a str),
    /// Where a run of a plan begins.
    Run(&'a PlannedRun),
}

/// What to do with a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Go {
    /// Drive it.
    Drive,
    /// Leave it out this time.
    Skip,
}

/// What was measured of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Seen {
    /// Poses on the robot's clock; none if nothing was measured.
    Track(Vec<TrackSample>),
    /// The run is to be driven again, and this one forgotten.
    Repeat,
    /// The run is to be left out.
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

/// By whose clock poses come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PoseClock {
    /// The robot's.
    Robot {
        /// How late they come is known, and taken off.
        delay_known: bool,
    },
    /// One of their own.
    Own,
}

/// A yaw rate: time on the robot's clock, rate \[s, rad/s\].
pub type YawRate = (f64, f64);

/// Measures where the robot is, and has it put at its marks.
pub trait PoseSource {
    /// Refuses what cannot measure anything, before the robot moves.
    fn check(&self) -> Result<()> {
        Ok(())
    }

    /// Has the robot put at a mark.
    fn place<'a>(&'a mut self, clock: &'a Clock, mark: Mark<'a>) -> Waiting<'a, Result<Go>>;

    /// Notes how far the track has come before a run: the number of the first pose that will be of it.
    fn begin(&mut self) -> Result<usize> {
        Ok(0)
    }

    /// What triggers it when a recording begins.
    fn trigger(&self) -> Option<Trigger> {
        None
    }

    /// Whether runs have measured poses without anybody being asked.
    fn sees(&self) -> bool {
        false
    }

    /// How many poses have been seen so far; `None` if it does not see the robot on its way.
    fn count(&self) -> Result<Option<usize>> {
        Ok(None)
    }

    /// The poses from this number on, by their own clock.
    fn poses_from(&self, _first: usize) -> Result<Vec<TrackSample>> {
        Ok(Vec::new())
    }

    /// The same, refused if they are too few for what was driven, which `what` names.
    fn poses_during(&self, first: usize, _what: &str) -> Result<Vec<TrackSample>> {
        self.poses_from(first)
    }

    /// By whose clock poses come.
    fn pose_clock(&self) -> PoseClock {
        PoseClock::Own
    }

    /// Noise of the poses that it sees, where that is known.
    fn noise(&self) -> Option<Sigma> {
        None
    }

    /// Reads how far the robot is off its line at the end, until `accept` takes what was read.
    fn read_deviation<'a>(
        &'a mut self,
        clock: &'a Clock,
        accept: &'a mut dyn FnMut(Deviation) -> Result<()>,
    ) -> Waiting<'a, Result<()>>;

    /// Reads how far the robot is ahead of its mark, and to the left of it \[m\].
    fn read_offset<'a>(&'a mut self, clock: &'a Clock) -> Waiting<'a, Result<[f64; 2]>>;

    /// What is measured of a run that has just ended: the poses from `first` on, or what somebody answers.
    fn measure<'a>(
        &'a mut self,
        clock: &'a Clock,
        first: usize,
        run: &'a PlannedRun,
        reckoned: &'a [Reckoned],
    ) -> Waiting<'a, Result<Seen>>;

    /// How well the last run was measured, where only whoever measured it knows.
    fn read_with(&self) -> Option<Sigma> {
        None
    }

    /// What a yaw rate sensor read during the run.
    fn yaw_rates(&mut self, _run: &str, _reckoned: &[Reckoned]) -> Result<Vec<YawRate>> {
        Ok(Vec::new())
    }

    /// Whether it is the simulator's own, whose robot is a new one in each process, and as old as it likes.
    fn is_simulated(&self) -> bool {
        false
    }
}

/// Where and how the robot is to stand for a run.
fn ask_for(run: &PlannedRun) -> String {
    let deg = run.heading_rad.to_degrees().rem_euclid(360.0);
    let facing = match deg.round() as u32 {
        0 | 360 => "facing along the campaign's x axis".to_owned(),
        deg => format!("facing {deg} degrees to the left of the campaign's x axis"),
    };
    let load = if run.payload_kg > 0.0 {
        format!(", with {} kg on board", run.payload_kg)
    } else {
        String::new()
    };
    format!("{}: put the robot at its mark, {facing}{load}.", run.name)
}

/// The user wants no more for now.
fn stopped() -> Error {
    Error::interrupted("stopped; the same command continues from here")
}

/// Nobody can be asked by this source.
fn cannot_read<'a, T: 'a>() -> Waiting<'a, Result<T>> {
    Box::pin(async { Err(Error::new("nothing measures where the robot is at the end")) })
}
