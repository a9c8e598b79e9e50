//! Who measures the robot during a campaign, and who puts it at its marks.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use robot_model::{Pose, TrackSample, Turns, path::dead_reckon};
use shared_proto::{Config, Telemetry};
use sim_target::Lab;

use super::align::{Reckoned, shift_s};
use super::gyro_log::GyroLog;
use super::plan::PlannedRun;
use super::samples::{camera_track, gyro_readings};
use crate::calibrate::{check_header, geometry, track_so_far};
use crate::error::{Error, Result};
use crate::session::Session;
use crate::track::read_track;
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
    /// A person who names a track file after each run, or has none.
    Person {
        /// Whether to ask before each run.
        confirm: bool,
    },
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
            Witness::Person { .. } | Witness::Nobody { .. } => false,
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
            Witness::TrackFile { confirm, .. }
            | Witness::Person { confirm }
            | Witness::Nobody { confirm } => *confirm,
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
                "q" | "quit" => {
                    return Err(Error::interrupted("stopped; the same command goes on from here"));
                }
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
            Witness::Person { .. } | Witness::Nobody { .. } => {}
            Witness::WithGyro { other, log } => {
                other.begin()?;
                log.begin()?;
            }
        }
        Ok(())
    }

    /// What was measured during the run, on the robot's clock; empty if nothing was.
    pub async fn track(
        &mut self,
        session: &mut Session,
        run: &PlannedRun,
        config: &Config,
        telemetry: &[Telemetry],
    ) -> Result<Vec<TrackSample>> {
        match self {
            Witness::Camera { lab, seen, .. } => Ok(camera_track(lab, *seen)),
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
                on_robot_clock(samples, config, telemetry).ok_or_else(|| no_shift(path))
            }
            Witness::Person { .. } => loop {
                let question =
                    "Its track, a CSV file (t_s,x_m,y_m[,heading_rad]), or Enter for none:";
                let answer = ui::ask(question, session.clock()).await?;
                if answer.is_empty() {
                    return Ok(Vec::new());
                }
                let path = Path::new(&answer);
                match read_track(path) {
                    Ok((samples, _)) => match on_robot_clock(samples, config, telemetry) {
                        Some(track) => return Ok(track),
                        None => ui::warn(no_shift(path)),
                    },
                    Err(error) => ui::warn(error),
                }
            },
            Witness::Nobody { .. } => Ok(Vec::new()),
            Witness::WithGyro { other, .. } => {
                Box::pin(other.track(session, run, config, telemetry)).await
            }
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

fn no_shift(path: &Path) -> Error {
    Error::new(format_args!("{} and the wheels have no motion in common", path.display()))
        .hint("is it the track of this run?")
}

/// A track by another clock, on the robot's. A track of a robot that stood still is put over the
/// telemetry as it is: there is no motion to go by, and none is needed.
fn on_robot_clock(
    mut samples: Vec<TrackSample>,
    config: &Config,
    telemetry: &[Telemetry],
) -> Option<Vec<TrackSample>> {
    let reckoned = reckoned(config, telemetry);
    let moved = |poses: &[Reckoned]| {
        poses.iter().any(|it| {
            let (a, b) = (it.pose, poses[0].pose);
            (a.x_m - b.x_m).hypot(a.y_m - b.y_m) > 0.02
                || (a.heading_rad - b.heading_rad).abs() > 0.05
        })
    };
    let shift_s = if moved(&reckoned) {
        shift_s(&samples, &reckoned)?
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
    let turns = telemetry.iter().map(|frame| Turns {
        phi_left_rad: angle(frame.wheels.left.counts, config.encoder.left),
        phi_right_rad: angle(frame.wheels.right.counts, config.encoder.right),
    });
    let poses =
        dead_reckon(Pose::ORIGIN, &geometry(config, 0.0), config.geometry.wheel_weight, turns);
    let times = telemetry.iter().map(|frame| frame.t_us as f64 * 1e-6);
    times.zip(poses).map(|(t_s, pose)| Reckoned { t_s, pose }).collect()
}
