//! How the robot's deviation is measured, and what a drive says once it is.

use std::f64::consts::TAU;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use robot_model::{
    Deviation, Experiment, FitOptions, Geometry, Leg, Pose, Track, TrackSample, Turns, WheelAngles,
    WheelWeight, fit_track, path::dead_reckon,
};
use shared_proto::{Config, Telemetry};
use sim_target::Lab;

use crate::error::{Error, Result};
use crate::motion::Recording;
use crate::picture::{EndReading, PathSource, RunReport};
use crate::quantity::Length;
use crate::session::Session;
use crate::track::read_track;
use crate::ui;

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
}

/// What a drive says.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// W_T, if the deviation is the radius alone.
    pub wheel_weight: WheelWeight,
    /// The drive, for the picture.
    pub run: RunReport,
    /// The drive as a leg of an out-and-back: from a track, without its first decimetres.
    pub leg: Leg,
    /// The ruler's reading as such, left positive \[m\], with its sigma; `None` from a track.
    pub offset_m: Option<(f64, f64)>,
}

impl Measurement {
    /// This drive as the way back after `out`.
    ///
    /// A track shows the turn of each drive by itself, and where on the way it happened: the first
    /// decimetres, in which a caster swings round and kicks, are left out. A ruler cannot do that. A ruler at the line reads where the robot is:
    /// with s the length of each way, y the readings after the way out and after the way back, the way
    /// out turned by alpha = -2 y_out / s and the way back by alpha = 2 (y_out + y_back) / s.
    pub(super) fn leg_after(&self, out: &Measurement) -> Leg {
        let leg = self.leg;
        match (out.offset_m, self.offset_m) {
            (Some((out_m, out_sigma_m)), Some((back_m, back_sigma_m))) => {
                let s_m = self
                    .run
                    .path
                    .first()
                    .zip(self.run.path.last())
                    .map_or(f64::NAN, |(a, b)| (b.x_m - a.x_m).hypot(b.y_m - a.y_m));
                Leg {
                    alpha_rad: 2.0 * (out_m + back_m) / s_m,
                    alpha_sigma_rad: 2.0 * out_sigma_m.hypot(back_sigma_m) / s_m,
                    ..leg
                }
            }
            _ => leg,
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
                match ui::ask(&question, session.clock()).await?.to_lowercase().as_str() {
                    "" | "y" | "yes" => Ok(()),
                    _ => Err(Error::interrupted("not driven")),
                }
            }
            _ => Ok(()),
        }
    }

    /// Notes where the track stands before a drive.
    pub(super) fn begin(&mut self) -> Result<()> {
        match self {
            Instrument::Camera(lab, seen) => *seen = lab.camera_len(),
            Instrument::TrackFile { path, seen, .. } => {
                check_header(path)?;
                *seen = track_so_far(path)?.len();
            }
            Instrument::Ruler(_) | Instrument::Person { .. } => {}
        }
        Ok(())
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
                let samples =
                    lab.camera_samples_from(*seen).into_iter().map(|sample| TrackSample {
                        t_s: sample.t_s,
                        x_m: sample.x_m,
                        y_m: sample.y_m,
                        heading_rad: Some(sample.heading_rad),
                    });
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
                    let answer = ui::ask(question, session.clock()).await?;
                    let measured = parse_reading(&answer, sigma_m).and_then(|deviation| {
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

/// Refuses a file that is no track before the robot moves; one that has only been created is fine.
pub(crate) fn check_header(path: &Path) -> Result<()> {
    let text = std::fs::read_to_string(path).map_err(|error| {
        Error::new(format_args!("cannot read the track {}: {error}", path.display()))
            .hint("start the tracking system first, so that the file is there")
    })?;
    let Some(header) = text.lines().next() else { return Ok(()) };
    for column in ["t_s", "x_m", "y_m"] {
        if !header.split(',').any(|name| name.trim() == column) {
            return Err(Error::new(format_args!(
                "{}:1: there is no column {column}",
                path.display()
            ))
            .hint("a track has a header line: t_s,x_m,y_m or t_s,x_m,y_m,heading_rad"));
        }
    }
    Ok(())
}

/// A track file as far as it has come: a tracking system may create it, or begin it, only when the
/// robot first moves.
pub(crate) fn track_so_far(path: &Path) -> Result<Vec<TrackSample>> {
    const HEADER_AND_TWO_ROWS: usize = 3;
    match std::fs::read_to_string(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        Ok(text) if text.lines().count() < HEADER_AND_TWO_ROWS => Ok(Vec::new()),
        Ok(text) => {
            let mut samples = read_track(path)?.0;
            if !text.ends_with('\n') {
                // The last row is still being written: a number may lack its last digits.
                samples.pop();
            }
            Ok(samples)
        }
        Err(_) => Ok(read_track(path)?.0),
    }
}

/// One length is the lateral offset, two are the paper's dx and dy.
fn parse_reading(text: &str, sigma_m: f64) -> std::result::Result<Deviation, String> {
    let lengths: Vec<Length> = join_units(text)
        .iter()
        .map(|part| part.parse().map_err(|error| format!("{error}")))
        .collect::<std::result::Result<_, _>>()?;
    match lengths.as_slice() {
        [offset] => Ok(Deviation::LateralOffset { y_m: offset.m, sigma_m }),
        [dx, dy] if dx.m > 0.0 => Ok(Deviation::Tangent { dx_m: dx.m, dy_m: dy.m, sigma_m }),
        [_, _] => Err("dx must be above zero".into()),
        _ => Err("give one length, or two: -36mm, or 2.525cm 1mm".into()),
    }
}

/// `2.5 cm 1mm` is two lengths, not three.
pub(super) fn join_units(text: &str) -> Vec<String> {
    let mut parts: Vec<String> = Vec::new();
    for word in text.split([' ', ',', ';']).filter(|word| !word.is_empty()) {
        match parts.last_mut() {
            Some(last) if word.starts_with(|c: char| c.is_alphabetic()) => last.push_str(word),
            _ => parts.push(word.into()),
        }
    }
    parts
}

impl Run<'_> {
    fn wheel_angles(&self) -> Vec<WheelAngles> {
        let encoder = self.config.encoder;
        let angle = |counts: i64, encoder: shared_proto::EncoderConfig| {
            counts as f64 * TAU / (encoder.counts_per_rev * encoder.gear_reduction)
        };
        let telemetry = &self.recording.telemetry;
        let frame = |frame: &Telemetry| WheelAngles {
            t_s: frame.t_us as f64 * 1e-6,
            turns: Turns {
                phi_left_rad: angle(frame.wheels.left.counts, encoder.left),
                phi_right_rad: angle(frame.wheels.right.counts, encoder.right),
            },
        };
        telemetry.iter().map(frame).collect()
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
        let leg = self.leg_by_track(track, options).unwrap_or(Leg::from(&fit.wheel_weight));
        Ok(Measurement { wheel_weight: fit.wheel_weight, run, leg, offset_m: None })
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
            radius_m * (turns.phi_left_rad + turns.phi_right_rad).abs() / 2.0
        };
        let run_in_m = RUN_IN_M.min(RUN_IN_SHARE_MAX * travelled_m(angles.last()?));
        let first = angles.iter().position(|angles| travelled_m(angles) >= run_in_m)?;
        let rest = Track {
            samples: track.samples.iter().filter(|s| s.t_s >= angles[first].t_s).copied().collect(),
            ..*track
        };
        let fit = fit_track(&rest, &angles[first..], self.geometry, options).ok()?;
        Some(Leg::from(&fit.wheel_weight))
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
        let leg = Leg::from(&wheel_weight);
        Ok(Measurement { wheel_weight, run, leg, offset_m })
    }

    /// A tracking system's clock starts when it likes: the robot's first movement is the same in both.
    ///
    /// What is left, a fraction of a second, is fitted as a delay.
    fn on_robot_clock(&self, mut samples: Vec<TrackSample>) -> Vec<TrackSample> {
        /// Far beyond any tracking noise, early in the first ramp \[m\].
        const MOVED_M: f64 = 0.02;
        let angles = self.wheel_angles();
        let radius_m = self.geometry.wheel_radius_m;
        let moved =
            |turns: Turns| radius_m * (turns.phi_left_rad + turns.phi_right_rad).abs() / 2.0;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_length_is_an_offset_and_two_are_the_papers_triangle() {
        let sigma_m = 0.0005;
        match parse_reading("-36 mm", sigma_m) {
            Ok(Deviation::LateralOffset { y_m, .. }) => assert!((y_m + 0.036).abs() < 1e-12),
            other => panic!("{other:?}"),
        }
        match parse_reading("2.525 cm, 1mm", sigma_m) {
            Ok(Deviation::Tangent { dx_m, dy_m, .. }) => {
                assert!((dx_m - 0.02525).abs() < 1e-12 && (dy_m - 0.001).abs() < 1e-12);
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn an_answer_without_a_unit_is_asked_again() {
        assert!(parse_reading("36", 0.0005).is_err());
        assert!(parse_reading("", 0.0005).is_err());
        assert!(parse_reading("1mm 2mm 3mm", 0.0005).is_err());
    }
}
