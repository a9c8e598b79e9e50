//! Tunes a robot: identifies its motors by voltages, computes feedforward and gains, and keeps them if they drive better.
//!
//! | file | what it does |
//! | --- | --- |
//! | `floor.rs` | where on its floor the robot is, and how far it may go |
//! | `experiments.rs` | the voltages, one experiment after the other |
//! | `recorded.rs` | the experiments as a campaign |
//! | `following.rs` | how well the wheels follow a profile |
//! | `rest.rs` | waits for wheels that a fault left rolling |
//! | `settings.rs` | from constants and gains to a configuration |
//! | `shortfall.rs` | what a drive shows to be missing in the feedforward |
//! | `trial.rs` | tries a configuration, and makes its feedforward better |

mod experiments;
mod floor;
mod following;
pub mod recorded;
mod rest;
pub mod result_tables;
mod settings;
mod shortfall;
mod trial;

use std::path::PathBuf;

use host_link::session::Session;
use robot_model::drivetrain::{DrivetrainFit, Gains, VoltageRecording};
use shared_proto::{Config, Identity};

pub use self::experiments::{DrivenExperiment, longer_count_m};
pub use self::following::{Following, Outcome as DriveOutcome, TraceSample};
pub use self::settings::LoopConfig;

use self::experiments::Experiments;
use self::floor::Floor;
use crate::error::{Error, Result};
use crate::interrupt;
use crate::undo::{self, Restorable, Undo};

/// What the user wants.
#[derive(Clone, Debug)]
pub struct Settings {
    /// How much floor there is ahead of the robot \[m\].
    pub floor_m: f64,
    /// The wheels turn in the air, each as far as on that floor.
    pub wheels_up: bool,
    /// 1 for the stiffest loop that keeps its margin, less for a softer one.
    pub stiffness: f64,
    /// Drives more experiments, and hands all of them over.
    pub record: bool,
    /// Where the old gains are remembered; nowhere for a robot that forgets.
    pub undo_folder: Option<PathBuf>,
}

/// Shortest floor on which motors can be told apart \[m\].
pub const FLOOR_M_MIN: f64 = 0.3;
/// Longest floor \[m\]: more is a slip of the pen.
pub const FLOOR_M_MAX: f64 = 100.0;
/// Each try to find gains that drive well is so much softer than the one before.
const SOFTER: f64 = 0.6;
/// So many tries.
const TRIES: u32 = 3;

/// What happens meanwhile.
pub enum Progress<'a> {
    /// This drives next, in a few words.
    Doing(&'a str),
    /// How the robot followed its profiles with the settings that it came with.
    Before(&'a DriveOutcome),
    /// All experiments were driven; only if they are to be recorded.
    Driven(&'a Config, &'a [DrivenExperiment]),
    /// What the motors are.
    Identified(&'a DrivetrainFit),
    /// These gains are tried next.
    Trying(&'a Gains),
    /// How the robot follows with them.
    After(&'a DriveOutcome),
}

/// What came of it.
pub struct Tuned {
    /// The robot.
    pub identity: Identity,
    /// Its wheels turned in the air.
    pub wheels_up: bool,
    /// The motors.
    pub fit: DrivetrainFit,
    /// The gains.
    pub gains: Gains,
    /// How the robot followed before.
    pub before: DriveOutcome,
    /// How it follows now.
    pub after: Following,
    /// The configuration as it was, and as it is saved.
    pub change: (LoopConfig, LoopConfig),
    /// Robot time that it took \[s\].
    pub took_s: f64,
    /// How far the robot went from where it stood \[m\].
    pub floor_used_m: f64,
    /// What the motors were identified from.
    pub experiments: Vec<(&'static str, VoltageRecording)>,
    /// The fast profile forwards, before and now; empty where the robot stopped with a fault.
    pub traces: [Vec<TraceSample>; 2],
}

/// Identifies, computes, drives, and saves what drives better. Whatever goes wrong, the motors are off and the robot has
/// the configuration that it came with.
pub async fn tune(
    session: &mut Session,
    settings: &Settings,
    progress: &mut dyn FnMut(Progress<'_>),
) -> Result<Tuned> {
    let identity = session.identify().await?;
    if identity.unsaved {
        return Err(Error::new("the robot has changes that are not saved").hint(
            "`beeline config save` keeps them, `beeline config restore` drops them; then tune",
        ));
    }
    if let Some(folder) = &settings.undo_folder {
        undo::check::<LoopConfig>(folder, &identity)?;
    }
    let original = session.read_config().await?;
    let tuned =
        Tuner { session, settings, original: &original, floor: Floor::new(settings.floor_m) }
            .run(identity, progress)
            .await;
    if tuned.is_err() {
        // If the link is lost, this fails as well; the change was never saved.
        let _lost = session.write_config(&original).await;
    }
    tuned
}

/// Drives all experiments without tuning: for what the motors are, not for gains. The robot has the configuration that it came with
/// afterwards, whatever happens.
pub async fn drive_experiments(
    session: &mut Session,
    floor_m: f64,
) -> Result<(Config, Vec<DrivenExperiment>)> {
    let original = session.read_config().await?;
    let supply_v = supply_v(session, &original).await?;
    let check = settings::for_experiments(&original, experiments::CHECK_FIRST);
    session.write_config(&check).await?;
    let mut experiments = Experiments::new(&original, supply_v);
    let mut floor = Floor::new(floor_m);
    let mut driven = experiments.run(session, &mut floor, &mut |_| {}).await.map(drop);
    if driven.is_ok() {
        driven = experiments.run_more(session, &mut floor, &mut |_| {}).await;
    }
    let restored = session.write_config(&original).await;
    driven?;
    restored?;
    let driven = experiments.driven();
    Ok((original, driven))
}

/// The supply at rest; where it is not measured, what the configuration takes it for.
async fn supply_v(session: &mut Session, config: &Config) -> Result<f64> {
    let status = session.status().await?;
    if config.protection.supply_v_min == 0.0 {
        return Ok(config.feedforward.nominal_v());
    }
    let supply_v = f64::from(status.supply_mv) * 1e-3;
    if supply_v < config.protection.supply_v_min {
        return Err(Error::new(format_args!("the supply is down to {supply_v:.2} V"))
            .hint("charge the battery, or switch the supply on"));
    }
    Ok(supply_v)
}

/// What every step needs.
struct Tuner<'a> {
    session: &'a mut Session,
    settings: &'a Settings,
    original: &'a Config,
    floor: Floor,
}

impl Tuner<'_> {
    async fn run(
        mut self,
        identity: Identity,
        progress: &mut dyn FnMut(Progress<'_>),
    ) -> Result<Tuned> {
        let started_us = self.session.status().await?.t_us;
        let supply_v = supply_v(self.session, self.original).await?;
        progress(Progress::Doing("a profile with the present gains"));
        let (before, trace_before) = self.drive_fast(self.original).await?;
        progress(Progress::Before(&before));
        let experiments = self.experiment(supply_v, progress).await?;
        let recordings: Vec<_> =
            experiments.iter().map(|(_, recording)| recording.clone()).collect();
        let fit = experiments::identify(&recordings)?;
        progress(Progress::Identified(&fit));
        let pushed = is_pushed(&fit)?;

        let counts_m = self.original.encoder.map(|e| self.original.meters_per_count(&e));
        let meters_per_count = counts_m.left.max(counts_m.right);
        let mut stiffness = self.settings.stiffness;
        let mut last = None;
        for _ in 0..TRIES {
            let gains = settings::design(self.original, &fit, supply_v, stiffness)?;
            progress(Progress::Trying(&gains));
            let tuned = settings::tuned(self.original, &fit, &gains, supply_v);
            let (tuned, after, trace) =
                self.try_settings(tuned, pushed, meters_per_count, progress).await?;
            match after {
                DriveOutcome::Followed(after)
                    if after.is_better_than(&before, meters_per_count) =>
                {
                    let change = (LoopConfig::of(self.original), LoopConfig::of(&tuned));
                    self.save(&identity, change).await?;
                    let ended_us = self.session.status().await?.t_us;
                    return Ok(Tuned {
                        identity,
                        wheels_up: self.settings.wheels_up,
                        fit,
                        gains,
                        before,
                        after,
                        change,
                        took_s: ended_us.saturating_sub(started_us) as f64 * 1e-6,
                        floor_used_m: self.floor.used_m(),
                        experiments,
                        traces: [trace_before, trace],
                    });
                }
                after => last = Some(after),
            }
            stiffness *= SOFTER;
        }
        if let Some(DriveOutcome::Faulted(fault)) = last
            && let Some(error) = experiments::too_coarse(self.original, fault)
        {
            return Err(error);
        }
        Err(not_better(&before, last.as_ref()))
    }

    /// Drives the experiments, and hands them over if they are to be recorded.
    async fn experiment(
        &mut self,
        supply_v: f64,
        progress: &mut dyn FnMut(Progress<'_>),
    ) -> Result<Vec<(&'static str, VoltageRecording)>> {
        let check = settings::for_experiments(self.original, experiments::CHECK_FIRST);
        self.session.write_config(&check).await?;
        let mut experiments = Experiments::new(self.original, supply_v);
        let mut driven = experiments
            .run(self.session, &mut self.floor, &mut |what| progress(Progress::Doing(what)))
            .await
            .map(drop);
        if self.settings.record && driven.is_ok() {
            driven = experiments
                .run_more(self.session, &mut self.floor, &mut |what| {
                    progress(Progress::Doing(what))
                })
                .await;
        }
        let experiments = experiments.driven();
        if self.settings.record {
            // Whatever ended them: what was driven is worth having.
            progress(Progress::Driven(self.original, &experiments));
        }
        driven?;
        let chosen = experiments.iter().filter(|one| one.identifies);
        Ok(chosen.filter_map(|one| Some((one.name, one.recording(self.original)?))).collect())
    }

    /// Remembers the old configuration, and saves the one in use.
    async fn save(
        &mut self,
        identity: &Identity,
        (before, after): (LoopConfig, LoopConfig),
    ) -> Result<()> {
        if self.session.is_cancelled() {
            return Err(Error::interrupted(format_args!(
                "{}; nothing is saved",
                interrupt::words()
            )));
        }
        let robot = identity.name.as_str().into();
        let undo = Undo { robot, before, after, odometry: None };
        let remembered = match &self.settings.undo_folder {
            Some(folder) => Some(undo.remember(folder, identity)?),
            None => None,
        };
        if let Err(error) = self.session.save_config().await {
            if let Some(remembered) = remembered {
                remembered.take_back()?;
            }
            return Err(error.into());
        }
        Ok(())
    }
}

/// Whether a slope or a cable pushes the robot; an error if its friction does not hold it.
fn is_pushed(fit: &DrivetrainFit) -> Result<bool> {
    match fit.constants.load_disturbance() {
        Some(push) if !push.held => Err(rest::rolls_by_itself()),
        push => Ok(push.is_some()),
    }
}

fn not_better(before: &DriveOutcome, after: Option<&DriveOutcome>) -> Error {
    let words = |outcome: Option<&DriveOutcome>| match outcome {
        Some(DriveOutcome::Followed(following)) => {
            format!("{:.2} mm rms from their setpoints", following.fast_rms_m * 1e3)
        }
        Some(DriveOutcome::Faulted(fault)) => format!("stopped by the fault {fault}"),
        None => "not driven".into(),
    };
    let hint = match after {
        Some(DriveOutcome::Faulted(_)) => {
            "first see whether that wheel is blocked, slips or has lost a wire; --stiffness 0.5 tries softer gains"
        }
        _ => {
            "--stiffness 0.5 tries softer gains; a gear with much play, or a loose wheel, has this effect"
        }
    };
    Error::said_no(format_args!(
        "the new gains do not drive better: the wheels were {}, and with the new gains {}; nothing is saved",
        words(Some(before)),
        words(after),
    ))
    .hint(hint)
}
