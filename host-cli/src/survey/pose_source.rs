//! Who measures the robot during a campaign, and who puts it at its marks.

use std::path::PathBuf;

use campaign::growing::{check_header, track_so_far};
use campaign::plan::PlannedRun;
use host_link::Session;
use shared_proto::{Config, Telemetry};
use sim_target::Lab;

use super::align::reckoned;
use super::gyro_log::GyroLog;
use super::measured::{Go, Seen, Sigma, no_shift, on_robot_clock, stopped};
use super::samples::{camera_track, gyro_readings};
use super::tape::Person;
use crate::error::{Error, Result};
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
                return person.place(&session.clock(), run, &ask_for(run)).await;
            }
            Witness::WithGyro { other, .. } => return Box::pin(other.place(session, run)).await,
        };
        if !confirm {
            return Ok(Go::Drive);
        }
        loop {
            let question =
                format!("{} Enter to drive, s to skip it, q to stop here:", ask_for(run));
            match ui::ask(&question, &session.clock()).await?.to_lowercase().as_str() {
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
                person.track(&session.clock(), &reckoned(config, telemetry)).await
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
