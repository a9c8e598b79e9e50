//! How the robot's deviation is measured, and what a drive says once it is.

use std::path::PathBuf;

use robot_model::calibration::out_and_back::OutAndBackError;
use robot_model::calibration::{
    Deviation, Experiment, FitOptions, Leg, OutAndBack, Shared, Track, TrackFit, TrackSample,
    WheelAngles, WheelWeight, fit_track,
};
use robot_model::kinematics::{Geometry, Pose, WheelPair, dead_reckon};
use shared_proto::{Config, GeometryConfig, Telemetry};
use sim_target::Lab;

use super::reading::parse_reading;
use crate::error::{Error, Result};
use crate::picture::{EndReading, PathSource, RunReport};
use crate::{ui, wheels};
use campaign::growing::{check_header, track_so_far};
use host_link::motion::Recording;
use host_link::session::Session;

/// What measures the robot.
pub enum Instrument {
    /// The simulator's overhead camera; the number of its samples before the drive.
    Camera(Lab, usize),
    /// The simulator's ruler.
    Ruler(Lab),
    /// A person with a ruler.
    Person {
        /// Resolution of the ruler \[m\].
        resolution_m: f64,
        /// Whether to ask that the robot be put at its line.
        confirm: bool,
    },
    /// A tracking system that appends to a file.
    TrackFile {
        /// The file.
        path: PathBuf,
        /// Noise of its positions \[m\].
        position_sigma_m: f64,
        /// Noise of its headings \[rad\].
        heading_sigma_rad: f64,
        /// Whether to ask that the robot be put at its line.
        confirm: bool,
        /// Samples in the file before the drive.
        seen: usize,
    },
}

/// A drive that is to be measured.
pub(super) struct Run<'a> {
    pub(super) recording: &'a Recording,
    pub(super) config: &'a Config,
    pub(super) geometry: &'a Geometry,
    pub(super) start_heading_sigma_rad: f64,
    /// What the way out was read by, if this is the way back.
    pub(super) way_out: Option<Deviation>,
}

/// What a drive says.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// W_T, if the deviation is the radius alone.
    pub wheel_weight: WheelWeight,
    /// The drive, for the picture.
    pub run: RunReport,
    /// What this drive is good for as a way of an out-and-back.
    pub way: Way,
}

/// A drive as one way of an out-and-back.
#[derive(Clone, Copy, Debug)]
pub enum Way {
    /// From a track, without its first decimetres, in which a caster swings round and kicks.
    Track(Leg),
    /// From what a person or the simulator's ruler read, which cannot leave them out.
    Reading(Experiment),
}

impl Measurement {
    /// What was read, unless it was a track.
    pub(super) fn deviation(&self) -> Option<Deviation> {
        match &self.way {
            Way::Track(_) => None,
            Way::Reading(experiment) => Some(experiment.deviation),
        }
    }

    /// Separates radius from pull by this drive and `back`, the same one backwards from where it ended.
    pub(super) fn and_back(
        &self,
        back: &Measurement,
        geometry: &Geometry,
    ) -> std::result::Result<OutAndBack, OutAndBackError> {
        match (&self.way, &back.way) {
            (Way::Track(out), Way::Track(back)) => {
                OutAndBack::new(*out, *back, Shared::TRACKS, geometry)
            }
            (Way::Reading(out), Way::Reading(back)) => OutAndBack::by_readings(out, back),
            _ => Err(OutAndBackError::Mixed),
        }
    }
}

impl Instrument {
    /// Has the robot put where a drive begins.
    pub(super) async fn prepare(&mut self, session: &mut Session, place: &str) -> Result<()> {
        match self {
            Instrument::Camera(lab, _) | Instrument::Ruler(lab) => {
                lab.place_at_start();
                Ok(())
            }
            Instrument::Person { confirm: true, .. }
            | Instrument::TrackFile { confirm: true, .. } => {
                let question = format!("Put the robot {place}, with room ahead, and press Enter:");
                match ui::ask(&question, &session.clock()).await?.to_lowercase().as_str() {
                    "" | "y" | "yes" => Ok(()),
                    _ => Err(Error::interrupted("not driven")),
                }
            }
            _ => Ok(()),
        }
    }

    /// Refuses what cannot measure anything, before the robot moves.
    pub(super) fn check(&self) -> Result<()> {
        if let Instrument::TrackFile { path, .. } = self {
            check_header(path)?.iter().for_each(ui::warn);
            track_so_far(path)?;
        }
        Ok(())
    }

    /// Notes where the track stands before a drive.
    pub(super) fn begin(&mut self) -> Result<()> {
        match self {
            Instrument::Camera(lab, seen) => *seen = lab.camera_len(),
            Instrument::TrackFile { path, seen, .. } => *seen = track_so_far(path)?.len(),
            Instrument::Ruler(_) | Instrument::Person { .. } => {}
        }
        Ok(())
    }

    /// The simulator's camera.
    pub(super) fn camera(&self) -> Option<Lab> {
        match self {
            Instrument::Camera(lab, _) => Some(lab.clone()),
            _ => None,
        }
    }

    /// Measures the drive that has just ended.
    pub(super) async fn measure(
        &mut self,
        session: &mut Session,
        run: &Run<'_>,
    ) -> Result<Measurement> {
        match self {
            Instrument::Camera(lab, seen) => {
                let parameters = lab.camera_parameters();
                let origin_us = run.origin_us();
                let end_us = run.recording.telemetry.last().map_or(0, |frame| frame.t_us);
                let end_s = end_us.saturating_sub(origin_us) as f64 * 1e-6;
                let samples =
                    lab.camera_samples_from(*seen).into_iter().map(|sample| TrackSample {
                        t_s: sample.s_since(origin_us),
                        x_m: sample.x_m,
                        y_m: sample.y_m,
                        heading_rad: Some(sample.heading_rad),
                    });
                // The camera runs on before and after; the recording is what is the same every time.
                let samples = samples.filter(|sample| (0.0..=end_s).contains(&sample.t_s));
                let track = Track {
                    samples: samples.collect(),
                    position_sigma_m: parameters.position_sigma_m,
                    heading_sigma_rad: parameters.heading_sigma_rad,
                };
                let options = FitOptions { delay: !parameters.delay_known };
                run.by_track(&track, options)
            }
            Instrument::TrackFile { path, position_sigma_m, heading_sigma_rad, seen, .. } => {
                let samples = track_so_far(path)?;
                let samples = samples.get(*seen..).unwrap_or_default().to_vec();
                if samples.len() < 10 {
                    return Err(Error::new(format_args!(
                        "{} got {} samples during the drive",
                        path.display(),
                        samples.len()
                    ))
                    .hint("is the tracking system running, and does it append to this file?"));
                }
                let track = Track {
                    samples: run.on_robot_clock(samples),
                    position_sigma_m: *position_sigma_m,
                    heading_sigma_rad: *heading_sigma_rad,
                };
                run.by_track(&track, FitOptions { delay: true })
            }
            Instrument::Ruler(lab) => {
                let reading = lab.read_offset();
                let sigma_m = lab.ruler_sigma_m();
                run.by_reading(Deviation::LateralOffset { y_m: reading.left_m, sigma_m })
            }
            Instrument::Person { resolution_m, .. } => {
                // Rounded to the nearest mark, and the eye that reads it.
                let sigma_m = *resolution_m / 2.0;
                loop {
                    let question = "Its offset from the line, left positive (-36mm), or dx and dy of the trace (2.525cm 1mm):";
                    let answer = ui::ask(question, &session.clock()).await?;
                    let measured = parse_reading(&answer, sigma_m).and_then(|deviation| {
                        run.check_kind(&deviation)?;
                        run.by_reading(deviation).map_err(|error| error.to_string())
                    });
                    match measured {
                        Ok(measurement) => return Ok(measurement),
                        Err(why) => ui::warn(why),
                    }
                }
            }
        }
    }
}

/// Takes off what wheels were steered against a pull, c \[rad/m\], so that it does not pass for their radii:
/// the robot has turned by (s_R - s_L)/b + c S, as one without a pull whose wheels rolled
/// s_R + b c S/2 and s_L - b c S/2, S its way without a sign.
fn unsteer(angles: &mut [WheelAngles], geometry: &GeometryConfig) {
    let GeometryConfig { wheel_radius_m, wheel_weight, .. } = *geometry;
    let bend = geometry.track_width_m * geometry.heading_pull_rad_per_m / 2.0;
    let (mut way_m, mut last) = (0.0, angles.first().map(|it| it.turns));
    for it in angles {
        if let Some(last) = last.replace(it.turns) {
            let step = it.turns.since(last);
            let left_m = wheel_radius_m * step.left;
            let right_m = wheel_radius_m * wheel_weight * step.right;
            way_m += ((left_m + right_m) / 2.0).abs();
        }
        it.turns.left -= bend * way_m / wheel_radius_m;
        it.turns.right += bend * way_m / (wheel_radius_m * wheel_weight);
    }
}

impl Run<'_> {
    /// When the recording begins, on the robot's clock \[us\]; times of this drive count from here.
    fn origin_us(&self) -> u64 {
        self.recording.telemetry.first().map_or(0, |frame| frame.t_us)
    }

    fn wheel_angles(&self) -> Vec<WheelAngles> {
        let telemetry = &self.recording.telemetry;
        let origin_us = self.origin_us();
        let frame = |frame: &Telemetry| WheelAngles {
            t_s: (frame.t_us - origin_us) as f64 * 1e-6,
            turns: wheels::turns(frame, self.config),
        };
        let mut angles = telemetry.iter().map(frame).collect::<Vec<_>>();
        unsteer(&mut angles, &self.config.geometry);
        angles
    }

    fn by_track(&self, track: &Track, options: FitOptions) -> Result<Measurement> {
        let angles = self.wheel_angles();
        let fit = fit_track(track, &angles, self.geometry, options).map_err(|error| {
            Error::new(format_args!("the measured track says nothing about the wheels: {error}"))
        })?;
        let points_m = track.samples.iter().map(|sample| {
            let pose = Pose::new(sample.x_m, sample.y_m, 0.0).seen_from(fit.start);
            (pose.x_m, pose.y_m)
        });
        let run = RunReport {
            driven_with: self.config.geometry.wheel_weight,
            path: fit.fitted.iter().map(|pose| pose.seen_from(fit.start)).collect(),
            path_source: PathSource::Measured,
            points_m: points_m.collect(),
            end: EndReading {
                lateral_offset_m: fit.end.y_m,
                lateral_offset_sigma_m: fit.end_offset_sigma_m,
                heading_rad: fit.end.heading_rad,
                heading_sigma_rad: fit.end_heading_sigma_rad,
            },
            wheel_weight: fit.wheel_weight.clone(),
        };
        // A drive too short to lose its run-in is taken whole.
        let leg = self.leg_by_track(track, options).unwrap_or_else(|| leg_of(&fit));
        Ok(Measurement { wheel_weight: fit.wheel_weight, run, way: Way::Track(leg) })
    }

    /// The drive without its run-in. What turned the robot there becomes part of its free start pose.
    fn leg_by_track(&self, track: &Track, options: FitOptions) -> Option<Leg> {
        /// A caster has swung round after about three of its trails \[m\].
        const RUN_IN_M: f64 = 0.3;
        /// A short drive keeps most of itself.
        const RUN_IN_SHARE_MAX: f64 = 0.25;
        let angles = self.wheel_angles();
        let radius_m = self.geometry.wheel_radius_m;
        let travelled_m = |to: &WheelAngles| {
            let turns = to.turns.since(angles[0].turns);
            radius_m * (turns.left + turns.right).abs() / 2.0
        };
        let run_in_m = RUN_IN_M.min(RUN_IN_SHARE_MAX * travelled_m(angles.last()?));
        let first = angles.iter().position(|angles| travelled_m(angles) >= run_in_m)?;
        let rest = Track {
            samples: track.samples.iter().filter(|s| s.t_s >= angles[first].t_s).copied().collect(),
            ..*track
        };
        let fit = fit_track(&rest, &angles[first..], self.geometry, options).ok()?;
        Some(leg_of(&fit))
    }

    /// Both ways must be read in the same way: an offset and an angle do not subtract.
    fn check_kind(&self, deviation: &Deviation) -> std::result::Result<(), String> {
        let is_offset = |it: &Deviation| matches!(it, Deviation::LateralOffset { .. });
        match self.way_out {
            Some(out) if is_offset(&out) && !is_offset(deviation) => {
                Err("the way out was read by its offset: read the way back by its offset too"
                    .into())
            }
            Some(out) if !is_offset(&out) && is_offset(deviation) => {
                Err("the way out was read by dx and dy: read the way back by dx and dy too".into())
            }
            _ => Ok(()),
        }
    }

    fn by_reading(&self, deviation: Deviation) -> Result<Measurement> {
        let angles = self.wheel_angles();
        let (Some(first), Some(last)) = (angles.first(), angles.last()) else {
            return Err(Error::new("the robot sent no telemetry during the drive"));
        };
        let experiment = Experiment {
            deviation,
            turns: last.turns.since(first.turns),
            geometry: *self.geometry,
            start_heading_sigma_rad: self.start_heading_sigma_rad,
        };
        let wheel_weight = experiment.wheel_weight().map_err(|error| {
            Error::new(error).hint("measure again; check the signs and the units")
        })?;
        let turns = angles.iter().map(|angles| angles.turns);
        let path = dead_reckon(Pose::ORIGIN, self.geometry, wheel_weight.value, turns);
        let end = path.last().copied().unwrap_or(Pose::ORIGIN);
        let length_m = end.x_m.hypot(end.y_m);
        let alpha_sigma_rad = wheel_weight.alpha_sigma_rad;
        let offset_m = match deviation {
            Deviation::LateralOffset { y_m, sigma_m } => Some((y_m, sigma_m)),
            _ => None,
        };
        let run = RunReport {
            driven_with: self.config.geometry.wheel_weight,
            path,
            path_source: PathSource::Reckoned,
            points_m: offset_m.map(|(y_m, _)| (end.x_m, y_m)).into_iter().collect(),
            end: EndReading {
                lateral_offset_m: offset_m.map_or(end.y_m, |(y_m, _)| y_m),
                lateral_offset_sigma_m: offset_m
                    .map_or(length_m * alpha_sigma_rad / 2.0, |(_, sigma_m)| sigma_m),
                heading_rad: end.heading_rad,
                heading_sigma_rad: alpha_sigma_rad,
            },
            wheel_weight: wheel_weight.clone(),
        };
        Ok(Measurement { wheel_weight, run, way: Way::Reading(experiment) })
    }

    /// A tracking system's clock starts when it likes: the robot's first movement is the same in both.
    ///
    /// What is left, a fraction of a second, is fitted as a delay.
    fn on_robot_clock(&self, mut samples: Vec<TrackSample>) -> Vec<TrackSample> {
        /// Far beyond any tracking noise, early in the first ramp \[m\].
        const MOVED_M: f64 = 0.02;
        let angles = self.wheel_angles();
        let radius_m = self.geometry.wheel_radius_m;
        let moved = |turns: WheelPair<f64>| radius_m * (turns.left + turns.right).abs() / 2.0;
        let robot_s = angles
            .iter()
            .find(|now| moved(now.turns.since(angles[0].turns)) > MOVED_M)
            .map(|now| now.t_s);
        let first = samples.first().copied();
        let track_s = first.and_then(|first| {
            let moved =
                |now: &&TrackSample| (now.x_m - first.x_m).hypot(now.y_m - first.y_m) > MOVED_M;
            samples.iter().find(moved).map(|now| now.t_s)
        });
        if let (Some(robot_s), Some(track_s)) = (robot_s, track_s) {
            for sample in &mut samples {
                sample.t_s += robot_s - track_s;
            }
        }
        samples
    }
}

/// A fitted track as a leg, with the length of way that the track shows.
fn leg_of(fit: &TrackFit) -> Leg {
    let WheelWeight { alpha_rad, alpha_sigma_rad, turns, .. } = fit.wheel_weight;
    let scaled = |phi_rad: f64| phi_rad * fit.scale.value;
    let turns = WheelPair { left: scaled(turns.left), right: scaled(turns.right) };
    Leg { alpha_rad, alpha_sigma_rad, turns }
}
