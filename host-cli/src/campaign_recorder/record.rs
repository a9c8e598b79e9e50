//! Records a campaign: drives the runs of a plan that its folder does not have yet.
//!
//! What the user sees is left to [`crate::command`].

use std::path::{Path, PathBuf};

use shared_proto::Config;

use super::clock::{LastRun, start_clock, wait_for};
use super::piece;
use super::resumed::{keep_plan, restore_facts};
use super::run::{RunOutcome, record_run};
use super::samples::robot_file;
use crate::error::{Error, Result};
use crate::hex::hex;
use crate::pose_source::{DriveOrSkip, Mark, PoseSource};
use campaign::model::in_use::{self, CompensationRecord};
use campaign::plan::{CampaignPlan, PlannedRun, plan_path};
use campaign::{Campaign, CampaignWriter, Place, Simulated, Warning};
use host_link::Session;

/// How to record.
#[derive(Clone, Debug)]
pub struct RecordSettings {
    /// Time between two telemetry frames \[ms\].
    pub period_ms: u16,
    /// Whether the plan is that of the whole campaign, kept in its folder; otherwise its runs are added.
    pub whole: bool,
    /// How many runs the folder had when its plan was made, if the plan depends on them.
    pub runs_there: Option<usize>,
    /// Start at least this long after the campaign's last run \[s\].
    pub later_s: f64,
    /// Noise of the measured positions, if it is known \[m\].
    pub position_sigma_m: Option<f64>,
    /// Noise of the measured headings, if it is known \[rad\].
    pub heading_sigma_rad: Option<f64>,
    /// The simulated robot, if it is one.
    pub simulated: Option<Simulated>,
}

impl Default for RecordSettings {
    /// 50 samples per second: a wheel at 0.4 m/s turns by 30 of 900 counts between two.
    fn default() -> Self {
        Self {
            period_ms: 20,
            whole: true,
            runs_there: None,
            later_s: 0.0,
            position_sigma_m: None,
            heading_sigma_rad: None,
            simulated: None,
        }
    }
}

/// How far the procedure is, for the caller.
#[derive(Debug)]
pub enum RecordStep<'a> {
    /// The robot compensates these effects already; they are in the model of the new campaign.
    Compensated(&'a [String]),
    /// The robot compensates another value of this effect than when the campaign began.
    CompensatedAnew(&'a str),
    /// The folder has this many runs of the plan already.
    Resumed(usize),
    /// This run of the folder had no facts in `robot.toml`, and now has those of the plan.
    FactsRestored(&'a str),
    /// A run begins: its number in the plan, from 1, and the number of runs.
    Started(usize, usize, &'a PlannedRun),
    /// The run is under way, with the share that is done.
    Driving(f64),
    /// The run is in the folder.
    Recorded {
        /// Its file.
        path: &'a Path,
        /// Its samples.
        samples: usize,
        /// Samples with a measured pose.
        poses: usize,
        /// Samples that were dropped because the line was too slow.
        dropped: u32,
    },
    /// The run was skipped.
    Skipped(&'a PlannedRun),
    /// Something that the user should know.
    Warning(&'a Warning),
}

/// What was recorded.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Runs of the plan that the folder had before.
    pub before: usize,
    /// Files of this call.
    pub recorded: Vec<PathBuf>,
    /// Names of the runs that were skipped.
    pub skipped: Vec<String>,
    /// Recorded runs without a measured pose.
    pub without_poses: usize,
}

/// Drives every run of the plan that the folder does not have, and writes each as soon as it is
/// complete. After an error all complete runs are kept; the same call goes on with the rest.
pub async fn record_campaign(
    session: &mut Session,
    source: &mut dyn PoseSource,
    plan: &CampaignPlan,
    folder: &Path,
    settings: &RecordSettings,
    tell: &mut dyn FnMut(RecordStep<'_>),
) -> Result<Summary> {
    let config = session.read_config().await?;
    // What is driven is what the file says, which has fewer digits: a campaign that is continued is driven by it.
    let plan = &CampaignPlan::parse(&plan_path(folder), &plan.to_toml())?;
    check_limits(plan, &config)?;
    let (writer, there) = open_folder(session, source, &config, folder, settings, tell).await?;
    if settings.whole {
        keep_plan(folder, plan, there.is_some())?;
    }
    let mut summary = Summary::default();
    let names = there.as_ref().map(Campaign::plain_names).unwrap_or_default();
    if settings.runs_there.is_some_and(|planned| planned != names.len()) {
        return Err(recorded_meanwhile(folder));
    }
    let is_there = |run: &PlannedRun| names.contains(&run.name);
    summary.before = plan.runs.iter().filter(|run| is_there(run)).count();
    if summary.before > 0 {
        tell(RecordStep::Resumed(summary.before));
    }
    if let Some(there) = there.as_ref().filter(|_| settings.whole) {
        let mut restored = |run: &str| tell(RecordStep::FactsRestored(run));
        restore_facts(&writer, there, plan, &mut restored)?;
    }
    let last = there.as_ref().and_then(|there| LastRun::of(folder, there));
    // A simulated robot is a new one in each process. It drives the runs that are there once more, so that the rest are those
    // of a campaign without an interruption, to the byte.
    let mut replayed = last.filter(|_| settings.whole && source.is_simulated());
    let last = if replayed.is_some() { None } else { last };
    let clock = start_clock(session, source, last, settings.later_s).await?;
    for (index, run) in plan.runs.iter().enumerate() {
        if is_there(run) {
            let is_last = plan.runs[index..].iter().all(is_there);
            if replayed.is_some() && !is_last {
                let mut quiet = |_: RecordStep<'_>| ();
                ask_and_record(session, source, &config, plan, run, settings, &mut quiet).await?;
            }
            continue;
        }
        if let Some(last) = replayed.take() {
            // Runs that are not of the plan were driven after those that are.
            wait_for(session, &clock, last.ended_s).await;
        }
        tell(RecordStep::Started(index + 1, plan.runs.len(), run));
        // Before the robot moves: a folder that cannot be written must not cost a run.
        drop(writer.start_run(&run.name, &[])?);
        let ran = ask_and_record(session, source, &config, plan, run, settings, tell).await?;
        let RunOutcome::Recorded(recorded) = ran else {
            tell(RecordStep::Skipped(run));
            summary.skipped.push(run.name.clone());
            continue;
        };
        if let Some(sigma) = source.reading_sigma() {
            let other = writer.keep_sigmas(sigma.position_m, sigma.heading_rad)?;
            other.iter().for_each(|warning| tell(RecordStep::Warning(warning)));
        }
        let path = recorded.write(&writer, run, clock.at(recorded.started_us))?;
        let (poses, samples, dropped) = (recorded.poses(), recorded.rows.len(), recorded.dropped);
        tell(RecordStep::Recorded { path: &path, samples, poses, dropped });
        summary.without_poses += usize::from(poses == 0);
        summary.recorded.push(path);
    }
    Ok(summary)
}

/// The error if a folder has other runs than those for which a run was planned.
pub fn recorded_meanwhile(folder: &Path) -> Error {
    let problem = format_args!("another process has just recorded into {}", folder.display());
    Error::new(problem).hint("give the command again")
}

/// Opens the folder for this robot, with warnings if the robot has changed; also returns the
/// campaign in it, if it has a run.
async fn open_folder(
    session: &mut Session,
    source: &dyn PoseSource,
    config: &Config,
    folder: &Path,
    settings: &RecordSettings,
    tell: &mut dyn FnMut(RecordStep<'_>),
) -> Result<(CampaignWriter, Option<Campaign>)> {
    let noise = source.noise().filter(|_| source.is_simulated());
    let mut robot = robot_file(config, noise);
    robot.position_sigma_m = settings.position_sigma_m.or(robot.position_sigma_m);
    robot.heading_sigma_rad = settings.heading_sigma_rad.or(robot.heading_sigma_rad);
    robot.simulated.clone_from(&settings.simulated);
    // A simulated robot has another uid with each seed, and still belongs to the same campaign.
    if !source.is_simulated() {
        robot.uid = Some(hex(&session.identify().await?.uid));
    }
    let writer = CampaignWriter::open(folder, &robot)?;
    let there = Campaign::read_if_any(folder)?;
    if let (Some(_), Some(before), Some(now)) =
        (&there, &writer.robot().simulated, &settings.simulated)
        && before != now
    {
        let place = Place::whole(&folder.join("robot.toml"));
        let (before, now) = (before.clone(), now.clone());
        tell(RecordStep::Warning(&Warning::OtherRobot { place, before, now }));
    }
    match in_use::record(folder, writer.robot(), config, there.is_some())? {
        CompensationRecord::Nothing => {}
        CompensationRecord::Written(ids) => tell(RecordStep::Compensated(&ids)),
        CompensationRecord::Changed(id) => tell(RecordStep::CompensatedAnew(&id)),
    }
    Ok((writer, there))
}

/// Has the robot put at the mark of a run and records it, again until the user does not want it
/// repeated.
async fn ask_and_record(
    session: &mut Session,
    source: &mut dyn PoseSource,
    config: &Config,
    plan: &CampaignPlan,
    run: &PlannedRun,
    settings: &RecordSettings,
    tell: &mut dyn FnMut(RecordStep<'_>),
) -> Result<RunOutcome> {
    loop {
        if source.place(&session.clock(), Mark::Run(run)).await? == DriveOrSkip::Skip {
            return Ok(RunOutcome::Skip);
        }
        let mut progress = |share| tell(RecordStep::Driving(share));
        let period_ms = settings.period_ms;
        match record_run(session, source, config, plan, run, period_ms, &mut progress).await? {
            RunOutcome::Repeat => {}
            other => return Ok(other),
        }
    }
}

/// Refuses, before anything moves, a plan beyond this robot's limits.
fn check_limits(plan: &CampaignPlan, config: &Config) -> Result<()> {
    let limits = config.limits;
    if plan.acceleration_mps2 > limits.acceleration_mps2_max {
        return Err(Error::new(format_args!(
            "the plan accelerates by {} m/s^2, limits.acceleration_mps2_max is {}",
            plan.acceleration_mps2, limits.acceleration_mps2_max
        ))
        .hint("lower acceleration_mps2 in the plan, or --acceleration"));
    }
    plan.check_durations(config.geometry.track_width_m)?;
    for run in &plan.runs {
        for piece in &run.pieces {
            let motion =
                piece::motion(piece, config.geometry.track_width_m, plan.acceleration_mps2);
            // A plan may reach the limit; rounding must not refuse it.
            if let Some(motion) = motion
                && motion.cruise > limits.speed_mps_max * (1.0 + 1e-9)
            {
                return Err(Error::new(format_args!(
                    "the run {} takes a wheel to {:.3} m/s, limits.speed_mps_max is {}",
                    run.name, motion.cruise, limits.speed_mps_max
                ))
                .hint("lower its speed in the plan, or --fast"));
            }
        }
    }
    Ok(())
}
