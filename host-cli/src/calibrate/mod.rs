//! Calibrates W_T: the paper's experiment as a guided procedure.
//!
//! Who measures is left to [`crate::pose_source`], what the user reads to [`crate::command`].
//!
//! ```text
//! check -> drive -> measure -> W_T -> write, read back -> drive -> measure -> better? -> repeats? -> save
//!                                          |                                     |         |
//!                                          +--- any error, Ctrl-C ---------------+---------+--> saved configuration back
//! ```
//!
//! The saved configuration changes in one place, at the very end. Until then the new W_T is only in
//! use, and if the procedure ends early, the saved one is restored.

mod driven_line;
mod mean_of_runs;
mod measurement;
pub mod plausibility;
mod pose_at_rest;
mod readiness;
mod repeatability;
pub mod umbmark;

pub use measurement::{Measurement, OneWay};
pub use readiness::Checks;

use std::path::PathBuf;

use robot_model::calibration::track_fit::Estimate;
use robot_model::calibration::wheel_weight::SIGMAS_95;
use robot_model::calibration::{CurvatureCause, Deviation, OutAndBack};
use robot_model::kinematics::Geometry;
use shared_proto::{Config, ConfigOrigin, Identity};

use self::driven_line::DrivenLine;
use self::mean_of_runs::{is_straight_within, mean};
use self::readiness::check;
use crate::calibration_page::Basis;
use crate::error::{Error, Result};
use crate::interrupt;
use crate::pose_source::{Mark, PoseSource};
use crate::undo::{self, Undo};
use crate::wheel_angles::geometry;
use crate::words;
use host_link::motion::{self, Motion, RecordOptions};
use host_link::session::Session;

/// How to calibrate.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The straight motion to drive.
    pub motion: Motion,
    /// How well wheel radius and track width are known, one sigma, as a share.
    pub tolerance_share: f64,
    /// How well the robot is lined up with its start line, one sigma \[rad\].
    pub start_heading_sigma_rad: f64,
    /// Also drive back, so that a pull is not taken for a radius.
    pub out_and_back: bool,
    /// Drive this many runs, each from the line, and take the mean of their W_T.
    pub runs: u16,
    /// The folder that remembers the old W_T for an undo; `None`: it is not remembered.
    pub undo_folder: Option<PathBuf>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            motion: Motion::PAPER,
            tolerance_share: 0.005,
            start_heading_sigma_rad: 0.002,
            out_and_back: false,
            runs: 1,
            undo_folder: None,
        }
    }
}

/// How far the procedure is, for the caller.
#[derive(Debug)]
pub enum CalibrateStep<'a> {
    /// Link, supply and state are in order.
    Checked(&'a Checks),
    /// A drive is under way, with the share that is done.
    Driving(CalibrationDrive, f64),
    /// A drive has been measured.
    Measured(CalibrationDrive, &'a Measurement),
    /// The way back was measured, and separates radius from pull.
    OutAndBack(&'a OutAndBack),
    /// The new W_T is in use and was read back.
    Written(f64),
    /// The new W_T survives power-off.
    Saved,
}

/// Which drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CalibrationDrive {
    /// With the old W_T.
    Before,
    /// With the old W_T, backwards.
    Back,
    /// With the new W_T.
    After,
    /// With the old W_T once more, where two drives cannot tell.
    Control,
}

/// The result of a calibration.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The checks before the first drive.
    pub checks: Checks,
    /// The nominal robot.
    pub geometry: Geometry,
    /// The run with the old W_T.
    pub before: Measurement,
    /// The result of the way back, if there was one.
    pub out_and_back: Option<OutAndBack>,
    /// The W_T of the decision.
    pub wheel_weight: Estimate,
    /// The runs on which it is based.
    pub basis: Basis,
    /// The number of drives.
    pub drives: u32,
    /// What was done.
    pub decision: Decision,
}

/// What a calibration did about the deviation.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "a calibration makes only one")]
pub enum Decision {
    /// The new W_T is saved; this is the run with it.
    Corrected(Measurement),
    /// The W_T in use is inside the 95 % interval, and that is narrow; nothing was written.
    AlreadyStraight,
    /// The W_T in use is inside the 95 % interval, but the interval is wide; nothing was written.
    CannotTell,
    /// The deviation comes from a pull alone; nothing was written.
    NotARadius,
    /// The run with the new W_T was not straighter; the saved one is in use again.
    NotBetter(Measurement),
    /// The drives differ by too much for the correction, here that with the new W_T and the one
    /// after it with the old: the saved one is in use again.
    NotRepeatable(Measurement, Measurement),
}

/// Calibrates the robot.
pub async fn calibrate(
    session: &mut Session,
    source: &mut dyn PoseSource,
    settings: &Settings,
    tell: &mut dyn FnMut(CalibrateStep<'_>),
) -> Result<Outcome> {
    source.check()?;
    let checks = check(session).await?;
    if let Some(folder) = &settings.undo_folder {
        undo::check::<undo::WheelWeight>(folder, &checks.identity)?;
    }
    tell(CalibrateStep::Checked(&checks));
    let config = checks.config.clone();
    let outcome = experiment(session, source, settings, checks, tell).await;
    if matches!(&outcome, Ok(Outcome { decision: Decision::Corrected(_), .. })) {
        return outcome;
    }
    let restored = put_back(session, &config).await;
    let outcome = outcome?;
    // An outcome promises that the old W_T is back; an error of the experiment says more than this
    // one.
    restored.map_err(|error| {
        Error::new(format_args!("the robot did not take the old W_T back: {error}"))
            .hint("the new one is not saved: switch the robot off and on")
    })?;
    Ok(outcome)
}

/// Restores the saved configuration if another one is in use.
async fn put_back(session: &mut Session, saved: &Config) -> Result<()> {
    if session.read_config().await? != *saved {
        session.restore_config(ConfigOrigin::Saved).await?;
    }
    Ok(())
}

async fn experiment(
    session: &mut Session,
    source: &mut dyn PoseSource,
    settings: &Settings,
    checks: Checks,
    tell: &mut dyn FnMut(CalibrateStep<'_>),
) -> Result<Outcome> {
    let config = checks.config.clone();
    let geometry = geometry(&config, settings.tolerance_share);
    let mut bench = Bench { session, source, settings, geometry, tell, way_out: None, drives: 0 };

    bench.place("at its start line").await?;
    let before = bench.drive(&config, CalibrationDrive::Before).await?;
    let mut measured = vec![before.wheel_weight.clone()];
    for _ in 1..settings.runs {
        bench.place("back at its start line").await?;
        measured.push(bench.drive(&config, CalibrationDrive::Before).await?.wheel_weight);
    }
    let mut wheel_weight = mean(&measured);
    let mut basis = match settings.runs {
        0 | 1 => Basis::OneRun,
        runs => Basis::Mean(runs),
    };
    let mut out_and_back = None;
    if settings.out_and_back {
        bench.way_out = before.deviation();
        let back = bench.drive(&config, CalibrationDrive::Back).await?;
        let both = before
            .and_back(&back, &geometry)
            .map_err(|error| Error::new(words::out_and_back_error(&error)))?;
        (bench.tell)(CalibrateStep::OutAndBack(&both));
        wheel_weight = Estimate { value: both.wheel_weight, sigma: both.wheel_weight_sigma };
        basis = Basis::BothWays;
        out_and_back = Some(both);
    }
    let outcome = |before, drives, decision| Outcome {
        checks: checks.clone(),
        geometry,
        before,
        out_and_back,
        wheel_weight,
        basis,
        drives,
        decision,
    };

    if out_and_back.is_some_and(|both| both.verdict == CurvatureCause::Pull) {
        return Ok(outcome(before, bench.drives, Decision::NotARadius));
    }
    let half_width = SIGMAS_95 * wheel_weight.sigma;
    if (wheel_weight.value - config.geometry.wheel_weight).abs() < half_width {
        let decision = if is_straight_within(half_width, &geometry) {
            Decision::AlreadyStraight
        } else {
            Decision::CannotTell
        };
        return Ok(outcome(before, bench.drives, decision));
    }
    let mut corrected = config;
    corrected.geometry.wheel_weight = wheel_weight.value;
    corrected.odometry.wheel_weight_sd = wheel_weight.sigma;
    plausibility::check(corrected.geometry)?;
    bench.session.write_config(&corrected).await?;
    (bench.tell)(CalibrateStep::Written(wheel_weight.value));

    let drives = measured.iter().map(|weight| weight.value).collect();
    let first = First { before: &before, drives, out_and_back };
    let decision = bench.drive_again(&corrected, first, &checks).await?;
    Ok(outcome(before, bench.drives, decision))
}

/// Remembers the old values, then saves those in use: in this order, because a robot that was
/// changed must be one that can be changed back.
async fn save<T: undo::Restorable>(
    session: &mut Session,
    undo_folder: Option<&std::path::Path>,
    identity: &Identity,
    undo: &Undo<T>,
) -> Result<()> {
    let Some(folder) = undo_folder else { return Ok(session.save_config().await?) };
    let remembered = undo.remember(folder, identity)?;
    if let Err(error) = session.save_config().await {
        remembered.take_back()?;
        return Err(error.into());
    }
    Ok(())
}

/// The drives with the old W_T.
struct First<'a> {
    /// The first of them.
    before: &'a Measurement,
    /// W_T of each, measured.
    drives: Vec<f64>,
    out_and_back: Option<OutAndBack>,
}

/// What every drive of the experiment needs.
struct Bench<'a> {
    session: &'a mut Session,
    source: &'a mut dyn PoseSource,
    settings: &'a Settings,
    geometry: Geometry,
    tell: &'a mut dyn FnMut(CalibrateStep<'_>),
    /// The reading of the way out, once it was read.
    way_out: Option<Deviation>,
    /// Drives so far.
    drives: u32,
}

impl Bench<'_> {
    async fn place(&mut self, words: &str) -> Result<()> {
        self.source.place(&self.session.clock(), Mark::Line(words)).await.map(drop)
    }

    async fn drive(&mut self, config: &Config, which: CalibrationDrive) -> Result<Measurement> {
        let motion = match which {
            CalibrationDrive::Back => self.settings.motion.reversed(),
            CalibrationDrive::Before | CalibrationDrive::After | CalibrationDrive::Control => {
                self.settings.motion
            }
        };
        let first = self.source.begin()?;
        let options = RecordOptions { trigger: self.source.trigger(), ..RecordOptions::default() };
        let tell = &mut self.tell;
        let recording = motion::drive(self.session, &motion, options, &mut |share| {
            tell(CalibrateStep::Driving(which, share));
        })
        .await?;
        let line = DrivenLine {
            recording: &recording,
            config,
            geometry: &self.geometry,
            start_heading_sigma_rad: self.settings.start_heading_sigma_rad,
            way_out: self.way_out.filter(|_| which == CalibrationDrive::Back),
        };
        self.drives += 1;
        let measurement = line.measure(self.source, &self.session.clock(), first).await?;
        (self.tell)(CalibrateStep::Measured(which, &measurement));
        Ok(measurement)
    }

    /// Drives once more with the new W_T, and saves it if the robot went straighter, and repeats
    /// well enough.
    async fn drive_again(
        &mut self,
        corrected: &Config,
        First { before, mut drives, out_and_back }: First<'_>,
        checks: &Checks,
    ) -> Result<Decision> {
        self.place("back at its start line").await?;
        let after = self.drive(corrected, CalibrationDrive::After).await?;
        // A pull bends both runs alike, and no W_T corrects it.
        let pull = out_and_back.filter(|both| both.verdict == CurvatureCause::Both);
        let pull_rad_per_m = pull.map_or(0.0, |both| both.pull_rad_per_m);
        if !after.is_straighter_than(before, pull_rad_per_m) {
            return Ok(Decision::NotBetter(after));
        }
        let (now, then) = (&after.wheel_weight, &before.wheel_weight);
        let correction = corrected.geometry.wheel_weight - checks.config.geometry.wheel_weight;
        if repeatability::is_third_needed(correction, then, now, &self.geometry) {
            self.session.write_config(&checks.config).await?;
            self.place("back at its start line").await?;
            let control = self.drive(&checks.config, CalibrationDrive::Control).await?;
            drives.extend([&after, &control].map(|drive| drive.wheel_weight.value));
            let repeats = repeatability::repeats(correction, &drives, &self.geometry);
            if !repeats || !after.is_straighter_than(&control, pull_rad_per_m) {
                return Ok(Decision::NotRepeatable(after, control));
            }
            self.session.write_config(corrected).await?;
        }
        self.save_after(corrected, before, &after, checks).await?;
        Ok(Decision::Corrected(after))
    }

    /// Saves the W_T in use.
    async fn save_after(
        &mut self,
        corrected: &Config,
        before: &Measurement,
        after: &Measurement,
        checks: &Checks,
    ) -> Result<()> {
        if self.session.is_cancelled() {
            return Err(Error::interrupted(format_args!(
                "{}; the new W_T is not saved",
                interrupt::words()
            )));
        }
        let undo = Undo {
            robot: checks.identity.name.as_str().into(),
            before: undo::WheelWeight(before.run.driven_with),
            after: undo::WheelWeight(after.run.driven_with),
            odometry: Some(checks.config.odometry),
        };
        let undo_folder = self.settings.undo_folder.as_deref();
        save(self.session, undo_folder, &checks.identity, &undo).await?;
        if self.session.restore_config(ConfigOrigin::Saved).await? != *corrected {
            return Err(Error::new(
                "the robot saved a different configuration from the one it was given",
            )
            .hint("`beeline config get` shows what is there"));
        }
        (self.tell)(CalibrateStep::Saved);
        Ok(())
    }
}
