//! The paper's experiment as a guided procedure.
//!
//! ```text
//! check -> drive -> measure -> W_T -> write, read back -> drive -> measure -> better? -> save
//!                                          |                                     |
//!                                          +--- any error, Ctrl-C ---------------+--> saved configuration back
//! ```
//!
//! The robot's saved configuration changes in one place, at the very end. Until then the new W_T
//! is only in use, and whatever ends the procedure early puts the saved one back.

mod measure;
pub mod umbmark;
mod undo;

pub use measure::{Instrument, Measurement};
pub(crate) use measure::{check_header, track_so_far};
pub use undo::{Undo, state_folder};

use robot_model::track_fit::Estimate;
use robot_model::wheel_weight::SIGMAS_95;
use robot_model::{Geometry, Leg, OutAndBack, Source, Verdict, WheelWeight};
use shared_proto::{Config, ConfigOrigin, Identity, State};

use crate::error::{Error, Result};
use crate::motion::{self, Motion, RecordOptions};
use crate::session::Session;

/// How to calibrate.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The straight motion to drive.
    pub motion: Motion,
    /// How well wheel radius and track width are known, one sigma, as a share.
    pub tolerance: f64,
    /// How well the robot is lined up with its start line, one sigma \[rad\].
    pub start_heading_sigma_rad: f64,
    /// Also drive back, so that a pull is not taken for a radius.
    pub out_and_back: bool,
    /// Drive this many runs, each from the line, and take the mean of what they say.
    pub runs: u16,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            motion: Motion::PAPER,
            tolerance: 0.005,
            start_heading_sigma_rad: 0.002,
            out_and_back: false,
            runs: 1,
        }
    }
}

/// Where the procedure is; told to whoever looks on.
#[derive(Debug)]
pub enum Step<'a> {
    /// Link, supply and state are good.
    Checked(&'a Checks),
    /// A drive is under way; the share that is done.
    Driving(Drive, f64),
    /// A drive has been measured.
    Measured(Drive, &'a Measurement),
    /// The way back said what kind of deviation it is.
    OutAndBack(&'a OutAndBack, &'a Leg),
    /// The new W_T is in use and was read back.
    Written(f64),
    /// The new W_T survives power-off.
    Saved,
}

/// Which drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drive {
    /// With the W_T that was there.
    Before,
    /// The same, backwards.
    Back,
    /// With the new W_T.
    After,
}

/// What was found before the first drive.
#[derive(Clone, Debug)]
pub struct Checks {
    /// Who the robot is.
    pub identity: Identity,
    /// Its configuration.
    pub config: Config,
    /// Questions asked to check the link.
    pub asked: u32,
    /// How many of these had to be repeated.
    pub repeated: u64,
    /// Supply \[V\].
    pub supply_v: f64,
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// What was found before the first drive.
    pub checks: Checks,
    /// The nominal robot.
    pub geometry: Geometry,
    /// The run with the W_T that was there.
    pub before: Measurement,
    /// What the way back said.
    pub out_and_back: Option<OutAndBack>,
    /// W_T as decided on: of the first run, or of both ways.
    pub wheel_weight: Estimate,
    /// What was done about it.
    pub decision: Decision,
}

/// What was done about the deviation.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one")]
pub enum Decision {
    /// The new W_T is saved; this is the run with it.
    Corrected(Measurement),
    /// The W_T in use is inside the 95 % interval, and that is narrow; nothing was written.
    AlreadyStraight,
    /// The W_T in use is inside the 95 % interval, but so is much else; nothing was written.
    CannotTell,
    /// The curvature comes from a pull alone; nothing was written.
    NotARadius,
    /// The run with the new W_T was no better; the saved one is back.
    NotBetter(Measurement),
}

/// Calibrates the robot.
pub async fn calibrate(
    session: &mut Session,
    instrument: &mut Instrument,
    settings: &Settings,
    tell: &mut dyn FnMut(Step<'_>),
) -> Result<Outcome> {
    instrument.begin()?;
    let checks = check(session).await?;
    tell(Step::Checked(&checks));
    let config = checks.config.clone();
    let outcome = experiment(session, instrument, settings, checks, tell).await;
    let keep = matches!(&outcome, Ok(Outcome { decision: Decision::Corrected(_), .. }));
    if !keep && session.read_config().await.is_ok_and(|now| now != config) {
        // Without a link this fails; what is saved is untouched all the same.
        let _ = session.restore_config(ConfigOrigin::Saved).await;
    }
    outcome
}

/// Link, state and supply, before anything moves. The robot itself checks its encoders' signs
/// before it closes the loop.
async fn check(session: &mut Session) -> Result<Checks> {
    const QUESTIONS: u32 = 20;
    let before = session.statistics().retries;
    let mut status = session.status().await?;
    for _ in 1..QUESTIONS {
        status = session.status().await?;
    }
    if let Some(report) = status.fault {
        return Err(Error::new(format_args!("a fault is latched: {}", report.fault))
            .hint(format_args!("{}; then `beeline clear`", report.fault.remedy())));
    }
    if status.state != State::Idle {
        return Err(Error::new(format_args!("the robot is {}", status.state.name()))
            .hint("`beeline stop` ends a motion"));
    }
    let identity = session.identify().await?;
    if identity.unsaved {
        // Left over from a calibration that was killed, or from a `config set` without a save.
        session.restore_config(ConfigOrigin::Saved).await?;
    }
    let config = session.read_config().await?;
    let supply_v = f64::from(session.status().await?.supply_mv) * 1e-3;
    if supply_v < config.protection.supply_v_min {
        return Err(Error::new(format_args!("the supply is down to {supply_v:.2} V"))
            .hint("charge the battery; protection.supply_v_min is the bound"));
    }
    let repeated = session.statistics().retries - before;
    Ok(Checks { identity, config, asked: QUESTIONS, repeated, supply_v })
}

async fn experiment(
    session: &mut Session,
    instrument: &mut Instrument,
    settings: &Settings,
    checks: Checks,
    tell: &mut dyn FnMut(Step<'_>),
) -> Result<Outcome> {
    let config = checks.config.clone();
    let geometry = geometry(&config, settings.tolerance);
    let mut bench = Bench { session, instrument, settings, geometry, tell };

    bench.instrument.prepare(bench.session, "at its start line").await?;
    let before = bench.drive(&config, Drive::Before).await?;
    let mut said = vec![before.wheel_weight.clone()];
    for _ in 1..settings.runs {
        bench.instrument.prepare(bench.session, "back at its start line").await?;
        said.push(bench.drive(&config, Drive::Before).await?.wheel_weight);
    }
    let mut wheel_weight = mean(&said);
    let mut out_and_back = None;
    if settings.out_and_back {
        let back = bench.drive(&config, Drive::Back).await?;
        let back = back.leg_after(&before);
        let both = OutAndBack::new(before.leg, back, &geometry).map_err(Error::new)?;
        (bench.tell)(Step::OutAndBack(&both, &back));
        wheel_weight = Estimate { value: both.wheel_weight, sigma: both.wheel_weight_sigma };
        out_and_back = Some(both);
    }
    let outcome = |before, decision| Outcome {
        checks,
        geometry,
        before,
        out_and_back,
        wheel_weight,
        decision,
    };

    if out_and_back.is_some_and(|both| both.verdict == Verdict::Pull) {
        return Ok(outcome(before, Decision::NotARadius));
    }
    let half_width = SIGMAS_95 * wheel_weight.sigma;
    if (wheel_weight.value - config.geometry.wheel_weight).abs() < half_width {
        let decision = if is_straight_within(half_width, &geometry) {
            Decision::AlreadyStraight
        } else {
            Decision::CannotTell
        };
        return Ok(outcome(before, decision));
    }
    let mut corrected = config;
    corrected.geometry.wheel_weight = wheel_weight.value;
    corrected.validate().map_err(|error| {
        Error::new(format_args!("the measured W_T is not believable: {error}"))
            .hint("check the readings, the track width and the counts per revolution")
    })?;
    bench.session.write_config(&corrected).await?;
    (bench.tell)(Step::Written(wheel_weight.value));

    bench.instrument.prepare(bench.session, "back at its start line").await?;
    let after = bench.drive(&corrected, Drive::After).await?;
    if after.wheel_weight.alpha_rad.abs() > before.wheel_weight.alpha_rad.abs() {
        return Ok(outcome(before, Decision::NotBetter(after)));
    }
    bench.session.save_config().await?;
    if bench.session.restore_config(ConfigOrigin::Saved).await? != corrected {
        return Err(Error::new("the robot saved another configuration than it was told to")
            .hint("`beeline config get` shows what is there"));
    }
    (bench.tell)(Step::Saved);
    Ok(outcome(before, Decision::Corrected(after)))
}

/// The mean of several runs, each weighted by what it alone adds.
///
/// What the runs have in common, the tolerances of the nominal robot, no mean makes smaller:
/// sigma^2 = 1 / sum(1 / own_i^2) + common^2.
fn mean(said: &[WheelWeight]) -> Estimate {
    let is_common = |source| matches!(source, Source::TrackWidth | Source::WheelRadius);
    let (mut common, mut total, mut sum) = (0.0_f64, 0.0, 0.0);
    for weight in said {
        let square = |common: bool| -> f64 {
            let parts = weight.contributions.iter().filter(|part| is_common(part.source) == common);
            parts.map(|part| part.sigma * part.sigma).sum()
        };
        let share = 1.0 / square(false).max(f64::MIN_POSITIVE);
        common = common.max(square(true));
        total += share;
        sum += share * weight.value;
    }
    Estimate { value: sum / total, sigma: (1.0 / total + common).sqrt() }
}

/// Whether a W_T that is wrong by this much still counts as straight: a centimetre in two metres.
///
/// The deviation angle after s metres is alpha = s dW / b, the offset from the line y = s alpha / 2.
fn is_straight_within(wheel_weight_error: f64, geometry: &Geometry) -> bool {
    const DISTANCE_M: f64 = 2.0;
    const OFFSET_M: f64 = 0.01;
    DISTANCE_M * DISTANCE_M * wheel_weight_error / (2.0 * geometry.track_width_m) <= OFFSET_M
}

/// What every drive of the experiment needs.
struct Bench<'a> {
    session: &'a mut Session,
    instrument: &'a mut Instrument,
    settings: &'a Settings,
    geometry: Geometry,
    tell: &'a mut dyn FnMut(Step<'_>),
}

impl Bench<'_> {
    async fn drive(&mut self, config: &Config, which: Drive) -> Result<Measurement> {
        let motion = match which {
            Drive::Back => self.settings.motion.reversed(),
            Drive::Before | Drive::After => self.settings.motion,
        };
        self.instrument.begin()?;
        let tell = &mut self.tell;
        let recording =
            motion::drive(self.session, &motion, RecordOptions::default(), &mut |share| {
                tell(Step::Driving(which, share));
            })
            .await?;
        let run = measure::Run {
            recording: &recording,
            config,
            geometry: &self.geometry,
            start_heading_sigma_rad: self.settings.start_heading_sigma_rad,
        };
        let measurement = self.instrument.measure(self.session, &run).await?;
        (self.tell)(Step::Measured(which, &measurement));
        Ok(measurement)
    }
}

/// The nominal robot of a configuration.
pub(crate) fn geometry(config: &Config, tolerance: f64) -> Geometry {
    let shared_proto::GeometryConfig { wheel_radius_m, track_width_m, .. } = config.geometry;
    let encoder = config.encoder.left;
    Geometry {
        wheel_radius_m,
        wheel_radius_sigma_m: wheel_radius_m * tolerance,
        track_width_m,
        track_width_sigma_m: track_width_m * tolerance,
        counts_per_wheel_rev: encoder.counts_per_rev * encoder.gear_reduction,
    }
}
