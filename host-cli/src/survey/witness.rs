//! Who measures the robot during a campaign, and who puts it at its marks.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use robot_model::calibration::TrackSample;
use robot_model::kinematics::{Pose, WheelPair, dead_reckon};
use shared_proto::{Config, Telemetry};
use sim_target::Lab;

use super::align::{Reckoned, shift_s};
use super::gyro_log::GyroLog;
use super::person::{Person, Sigma};
use super::plan::PlannedRun;
use super::samples::{camera_track, gyro_readings};
use crate::calibrate::{check_header, geometry, track_so_far};
use crate::error::{Error, Result};
use crate::session::Session;
use crate::ui;

/// Who measures the robot, and puts it at its marks.
pub enum Witness {
    /// The simulator's overhead camera, and its person who carries the robot.
    Camera {
        /// The laboratory.
        lab: Lab,
        /// Camera samples before the run.
        seen: usize,
        /// Readings of the yaw rate sensor before the run.
        gyro_seen: usize,
    },
    /// A tracking system that appends to a file.
    TrackFile {
        /// The file.
        path: PathBuf,
        /// Whether to ask before each run.
        confirm: bool,
        /// Samples in the file before the run.
        seen: usize,
    },
    /// A person with a tape, or with a track file for each run.
    Person(Person),
    /// Nobody: poses are added to the files later.
    Nobody {
        /// Whether to ask before each run.
        confirm: bool,
    },
    /// One of the others, and a yaw rate sensor that is logged to a file.
    WithGyro {
        /// Who measures the pose.
        other: Box<Witness>,
        /// The sensor's log.
        log: GyroLog,
    },
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

/// How long the simulator's person takes to carry the robot to its mark \[s\].
const CARRY_S: u64 = 10;

impl Witness {
    /// The simulator's camera.
    pub fn camera(lab: Lab) -> Self {
        Witness::Camera { lab, seen: 0, gyro_seen: 0 }
    }

    /// Whether runs have measured poses without anybody being asked.
    pub fn sees(&self) -> bool {
        match self {
            Witness::Camera { .. } | Witness::TrackFile { .. } => true,
            Witness::Person(_) | Witness::Nobody { .. } => false,
            Witness::WithGyro { other, .. } => other.sees(),
        }
    }

    /// Has the robot put at the mark of a run.
    pub async fn place(&mut self, session: &mut Session, run: &PlannedRun) -> Result<Go> {
        let confirm = match self {
            Witness::Camera { lab, .. } => {
                session.clock().sleep(std::time::Duration::from_secs(CARRY_S)).await;
                lab.set_payload(run.payload_kg);
                lab.place_on(sim_target::plant::Pose {
                    heading_rad: run.heading_rad,
                    ..sim_target::plant::Pose::default()
                });
                return Ok(Go::Drive);
            }
            Witness::TrackFile { confirm, .. } | Witness::Nobody { confirm } => *confirm,
            Witness::Person(person) => {
                return person.place(session.clock(), run, &ask_for(run)).await;
            }
            Witness::WithGyro { other, .. } => return Box::pin(other.place(session, run)).await,
        };
        if !confirm {
            return Ok(Go::Drive);
        }
        loop {
            let question =
                format!("{} Enter to drive, s to skip it, q to stop here:", ask_for(run));
            match ui::ask(&question, session.clock()).await?.to_lowercase().as_str() {
                "" | "y" | "yes" => return Ok(Go::Drive),
                "s" | "skip" => return Ok(Go::Skip),
                "q" | "quit" => return Err(stopped()),
                _ => {}
            }
        }
    }

    /// Notes where the track stands before a run.
    pub fn begin(&mut self) -> Result<()> {
        match self {
            Witness::Camera { lab, seen, gyro_seen } => {
                *seen = lab.camera_len();
                *gyro_seen = lab.gyro_len();
            }
            Witness::TrackFile { path, seen, .. } => {
                check_header(path)?.iter().for_each(ui::warn);
                *seen = track_so_far(path)?.len();
            }
            Witness::Person(_) | Witness::Nobody { .. } => {}
            Witness::WithGyro { other, log } => {
                other.begin()?;
                log.begin()?;
            }
        }
        Ok(())
    }

    /// What was measured during the run, on the robot's clock.
    pub async fn track(
        &mut self,
        session: &mut Session,
        run: &PlannedRun,
        config: &Config,
        telemetry: &[Telemetry],
    ) -> Result<Seen> {
        match self {
            Witness::Camera { lab, seen, .. } => Ok(Seen::Track(camera_track(lab, *seen))),
            Witness::TrackFile { path, seen, .. } => {
                let samples = track_so_far(path)?.get(*seen..).unwrap_or_default().to_vec();
                if samples.len() < 10 {
                    return Err(Error::new(format_args!(
                        "{} got {} samples during the run {}",
                        path.display(),
                        samples.len(),
                        run.name
                    ))
                    .hint("is the tracking system running, and does it append to this file?"));
                }
                let track = on_robot_clock(samples, &reckoned(config, telemetry));
                track.map(Seen::Track).ok_or_else(|| no_shift(path))
            }
            Witness::Person(person) => {
                person.track(session.clock(), &reckoned(config, telemetry)).await
            }
            Witness::Nobody { .. } => Ok(Seen::Track(Vec::new())),
            Witness::WithGyro { other, .. } => {
                Box::pin(other.track(session, run, config, telemetry)).await
            }
        }
    }

    /// How well the last run was measured, where the witness alone knows.
    pub fn sigma(&self) -> Option<Sigma> {
        match self {
            Witness::Person(person) => person.sigma(),
            Witness::WithGyro { other, .. } => other.sigma(),
            _ => None,
        }
    }

    /// What a yaw rate sensor read during the run: time on the robot's clock, rate \[s, rad/s\].
    pub fn gyro(
        &mut self,
        run: &PlannedRun,
        config: &Config,
        telemetry: &[Telemetry],
    ) -> Result<Vec<(f64, f64)>> {
        match self {
            Witness::Camera { lab, gyro_seen, .. } => Ok(gyro_readings(lab, *gyro_seen)),
            Witness::WithGyro { log, .. } => log.take(&run.name, &reckoned(config, telemetry)),
            _ => Ok(Vec::new()),
        }
    }
}

/// Where and how the robot is to stand.
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
pub(super) fn stopped() -> Error {
    Error::interrupted("stopped; the same command goes on from here")
}

pub(super) fn no_shift(path: &Path) -> Error {
    Error::new(format_args!("{} and the wheels have no motion in common", path.display()))
        .hint("is it the track of this run?")
}

/// A track by another clock, on the robot's. A track of a robot that stood still is put over the
/// telemetry as it is: there is no motion to go by, and none is needed.
pub(super) fn on_robot_clock(
    mut samples: Vec<TrackSample>,
    reckoned: &[Reckoned],
) -> Option<Vec<TrackSample>> {
    let moved = |poses: &[Reckoned]| {
        poses.iter().any(|it| {
            let (a, b) = (it.pose, poses[0].pose);
            (a.x_m - b.x_m).hypot(a.y_m - b.y_m) > 0.02
                || (a.heading_rad - b.heading_rad).abs() > 0.05
        })
    };
    let shift_s = if moved(reckoned) {
        shift_s(&samples, reckoned)?
    } else {
        reckoned.first()?.t_s - samples.first()?.t_s
    };
    samples.iter_mut().for_each(|it| it.t_s += shift_s);
    Some(samples)
}

/// The robot by its wheels, from anywhere, with the configuration in use.
pub(crate) fn reckoned(config: &Config, telemetry: &[Telemetry]) -> Vec<Reckoned> {
    let angle = |counts: i64, encoder: shared_proto::EncoderConfig| {
        counts as f64 * TAU / (encoder.counts_per_rev * encoder.gear_reduction)
    };
    let turns = telemetry.iter().map(|frame| WheelPair {
        left: angle(frame.wheels.left.counts, config.encoder.left),
        right: angle(frame.wheels.right.counts, config.encoder.right),
    });
    let poses =
        dead_reckon(Pose::ORIGIN, &geometry(config, 0.0), config.geometry.wheel_weight, turns);
    let times = telemetry.iter().map(|frame| frame.t_us as f64 * 1e-6);
    times.zip(poses).map(|(t_s, pose)| Reckoned { t_s, pose }).collect()
}
