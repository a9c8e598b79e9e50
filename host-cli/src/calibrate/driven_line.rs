//! What a drive along a line says about the wheels: by measured poses, or by a reading at its end.
//!
//! Who measures is left to [`crate::pose_source`]; what is decided, to the module above.

use host_link::Clock;
use host_link::motion::Recording;
use robot_model::calibration::{
    Deviation, Experiment, FitOptions, Leg, Track, TrackFit, TrackSample, WheelAngles, WheelWeight,
    fit_track,
};
use robot_model::kinematics::{Geometry, Pose, WheelPair, dead_reckon};
use shared_proto::{Config, GeometryConfig, Telemetry};

use super::measurement::{Measurement, OneWay};
use super::pose_at_rest;
use crate::calibration_page::{EndReading, PathSource, RunReport};
use crate::campaign_recorder::samples::seconds;
use crate::error::{Error, Result};
use crate::pose_source::{PoseClock, PoseSource, Sigma};
use crate::wheel_angles;
use crate::words;

/// A drive that is to be measured.
pub(super) struct DrivenLine<'a> {
    pub(super) recording: &'a Recording,
    pub(super) config: &'a Config,
    pub(super) geometry: &'a Geometry,
    pub(super) start_heading_sigma_rad: f64,
    /// The reading of the way out, if this is the way back.
    pub(super) way_out: Option<Deviation>,
}

/// Removes the steering against a pull, c \[rad/m\], from the wheel angles, so that it is not taken
/// for a difference of the radii: the robot turned by (s_R - s_L)/b + c S, as one without a pull
/// whose wheels rolled s_R + b c S/2 and s_L - b c S/2, with S the distance travelled, forwards or
/// backwards.
fn remove_steering(angles: &mut [WheelAngles], geometry: &GeometryConfig) {
    let GeometryConfig { wheel_radius_m, wheel_weight, .. } = *geometry;
    let bend = geometry.track_width_m * geometry.heading_pull_rad_per_m / 2.0;
    let (mut way_m, mut last) = (0.0, angles.first().map(|first| first.turns));
    for now in angles {
        if let Some(last) = last.replace(now.turns) {
            let step = now.turns.since(last);
            let left_m = wheel_radius_m * step.left;
            let right_m = wheel_radius_m * wheel_weight * step.right;
            way_m += ((left_m + right_m) / 2.0).abs();
        }
        now.turns.left -= bend * way_m / wheel_radius_m;
        now.turns.right += bend * way_m / (wheel_radius_m * wheel_weight);
    }
}

impl DrivenLine<'_> {
    /// Has the drive that just ended measured; its poses are those from `first` on.
    pub(super) async fn measure(
        &self,
        source: &mut dyn PoseSource,
        clock: &Clock,
        first: usize,
    ) -> Result<Measurement> {
        if !source.measures_while_driving() {
            let mut measured = None;
            source
                .read_deviation(clock, &mut |deviation| {
                    self.check_kind(&deviation)?;
                    measured = Some(self.by_reading(deviation)?);
                    Ok(())
                })
                .await?;
            return measured.ok_or_else(|| {
                Error::new("the robot's position at the end of the drive was not read")
            });
        }
        let poses = source.poses_during(first, "drive")?;
        let (samples, delay) = match source.pose_clock() {
            PoseClock::Robot { delay_known } => (self.during(poses), !delay_known),
            PoseClock::Own => (self.on_robot_clock(poses), true),
        };
        let Some(Sigma { position_m, heading_rad }) = source.noise() else {
            return Err(Error::new("the noise of the measured track is not known")
                .hint("give --position-sigma and --heading-sigma"));
        };
        let track = Track { samples, position_sigma_m: position_m, heading_sigma_rad: heading_rad };
        self.by_track(&track, FitOptions { delay })
    }

    /// Poses with times on the robot's clock, moved to the recording's. Poses before and after the
    /// recording are dropped: the camera runs longer, and not always equally long.
    fn during(&self, mut poses: Vec<TrackSample>) -> Vec<TrackSample> {
        let origin_us = self.origin_us();
        let end_us = self.recording.telemetry.last().map_or(0, |frame| frame.t_us);
        let end_s = end_us.saturating_sub(origin_us) as f64 * 1e-6;
        for pose in &mut poses {
            // In whole microseconds, so that equal instants of two recordings have equal bits,
            // however long the robot has been switched on.
            pose.t_s = ((pose.t_s * 1e6).round() - origin_us as f64) * 1e-6;
        }
        poses.retain(|pose| (0.0..=end_s).contains(&pose.t_s));
        poses
    }

    /// When the recording begins, on the robot's clock \[us\]; times of this drive count from here.
    fn origin_us(&self) -> u64 {
        self.recording.telemetry.first().map_or(0, |frame| frame.t_us)
    }

    fn wheel_angles(&self) -> Vec<WheelAngles> {
        let telemetry = &self.recording.telemetry;
        let origin_us = self.origin_us();
        let frame = |frame: &Telemetry| WheelAngles {
            t_s: seconds(origin_us, frame.t_us),
            turns: wheel_angles::turns(frame, self.config),
        };
        let mut angles = telemetry.iter().map(frame).collect::<Vec<_>>();
        remove_steering(&mut angles, &self.config.geometry);
        angles
    }

    fn by_track(&self, track: &Track, options: FitOptions) -> Result<Measurement> {
        let angles = self.wheel_angles();
        let fit = fit_track(track, &angles, self.geometry, options).map_err(|error| {
            let why = words::track_fit_error(&error);
            Error::new(format_args!("the measured track does not determine W_T: {why}"))
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
        // A drive that is too short without its run-in is used whole.
        let leg = self.leg_by_track(track, options).unwrap_or_else(|| leg_of(&fit));
        let offset_m = pose_at_rest::offset_m(&track.samples, &angles);
        Ok(Measurement { wheel_weight: fit.wheel_weight, run, way: OneWay::Track(leg), offset_m })
    }

    /// The drive without its run-in. The turn during the run-in becomes part of the fitted start
    /// pose.
    fn leg_by_track(&self, track: &Track, options: FitOptions) -> Option<Leg> {
        /// A caster has swung round after about three of its trails \[m\].
        const RUN_IN_M: f64 = 0.3;
        /// The run-in is at most this share of a short drive.
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

    /// Both ways must be read by the same method: an offset and an angle cannot be subtracted.
    fn check_kind(&self, deviation: &Deviation) -> Result<()> {
        let is_offset =
            |deviation: &Deviation| matches!(deviation, Deviation::LateralOffset { .. });
        match self.way_out {
            Some(out) if is_offset(&out) && !is_offset(deviation) => Err(Error::new(
                "the way out was read by its offset: read the way back by its offset too",
            )),
            Some(out) if !is_offset(&out) && is_offset(deviation) => Err(Error::new(
                "the way out was read by dx and dy: read the way back by dx and dy too",
            )),
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
            Error::new(words::wheel_weight_error(&error))
                .hint("measure again; check the signs and the units")
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
        let offset_m = offset_m.map(|(y_m, _)| y_m);
        Ok(Measurement { wheel_weight, run, way: OneWay::Reading(experiment), offset_m })
    }

    /// A track moved to the robot's clock. The tracking system's clock has an unknown start, so the
    /// robot's first movement is taken to be at the same time in both.
    ///
    /// The remaining delay, a fraction of a second, is fitted.
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

/// A fitted track as a leg, with the wheel angles scaled to the length of the track.
fn leg_of(fit: &TrackFit) -> Leg {
    let WheelWeight { alpha_rad, alpha_sigma_rad, turns, .. } = fit.wheel_weight;
    let scaled = |phi_rad: f64| phi_rad * fit.scale.value;
    let turns = WheelPair { left: scaled(turns.left), right: scaled(turns.right) };
    Leg { alpha_rad, alpha_sigma_rad, turns }
}
