//! Records a campaign: drives the runs of a plan that its folder does not have yet.
//!
//! What the user sees is left to [`crate::command`].

use std::path::{Path, PathBuf};
use std::time::Duration;

use robot_model::recording::Piece;
use shared_proto::{Command, Config, Telemetry};

use super::clock::{LastRun, start_clock, wait_for};
use super::continued::{keep_plan, planned_facts, restore_facts};
use super::piece;
use super::samples::{columns, on_one_encoder, robot_file, rows};
use crate::error::{Error, Result};
use crate::hex::hex;
use crate::pose_source::align::reckoned;
use crate::pose_source::{Go, Mark, PoseSource, Seen};
use campaign::model::in_use::{self, Kept};
use campaign::plan::{CampaignPlan, PAUSE_S, PlannedRun, plan_path};
use campaign::{Campaign, CampaignWriter, Place, Row, RunFacts, Simulated, Warning};
use host_link::Session;
use host_link::motion::{self, RecordOptions};

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

/// One run as recorded.
#[derive(Clone, Debug)]
pub struct RecordedRun {
    /// Its samples.
    pub rows: Vec<Row>,
    /// When it began, on the session's clock \[us\].
    pub started_us: u64,
    /// Samples that were dropped because the line was too slow.
    pub dropped: u32,
}

impl RecordedRun {
    /// Samples with a measured pose.
    pub fn poses(&self) -> usize {
        self.rows.iter().filter(|row| row.x_m.is_some()).count()
    }

    /// Whether a yaw rate was measured.
    pub fn has_gyro(&self) -> bool {
        self.rows.iter().any(|row| row.gyro_z_rad_s.is_some())
    }
}

/// The result of one run.
#[derive(Clone, Debug)]
pub enum RunOutcome {
    /// It was recorded.
    Recorded(RecordedRun),
    /// It is to be driven again.
    Repeat,
    /// It is to be skipped.
    Skip,
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
        let poses = recorded.poses();
        let mut file = writer.start_run(&run.name, &columns(poses > 0, recorded.has_gyro()))?;
        recorded.rows.iter().try_for_each(|row| file.push(row))?;
        let path = file.finish(RunFacts {
            started_s: Some((clock.at(recorded.started_us) * 1e3).round() / 1e3),
            ..planned_facts(run)
        })?;
        let (samples, dropped) = (recorded.rows.len(), recorded.dropped);
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
    match in_use::keep(folder, writer.robot(), config, there.is_some())? {
        Kept::Nothing => {}
        Kept::Written(ids) => tell(RecordStep::Compensated(&ids)),
        Kept::Changed(id) => tell(RecordStep::CompensatedAnew(&id)),
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
        if source.place(&session.clock(), Mark::Run(run)).await? == Go::Skip {
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

/// Drives one run, has it measured, and leaves the robot at standstill with its motors off.
pub async fn record_run(
    session: &mut Session,
    source: &mut dyn PoseSource,
    config: &Config,
    plan: &CampaignPlan,
    run: &PlannedRun,
    period_ms: u16,
    progress: &mut dyn FnMut(f64),
) -> Result<RunOutcome> {
    let dropped_before = session.status().await?.link.telemetry_dropped;
    source.check()?;
    let first = source.begin()?;
    let started_us = session.clock().now_us();
    let track_m = config.geometry.track_width_m;
    let options = RecordOptions {
        period_ms,
        rest: Duration::from_secs_f64(PAUSE_S),
        // A camera records the pauses between the pieces as well.
        trigger: None,
    };
    let whole_s = run.duration_s(track_m, plan.acceleration_mps2);
    let mut telemetry = Vec::new();
    let mut done_s = 0.0;
    for piece in &run.pieces {
        let piece_s = piece.duration_s(track_m, plan.acceleration_mps2);
        let mut at = |share: f64| progress(((done_s + share * piece_s) / whole_s).min(1.0));
        match (piece, piece::motion(piece, track_m, plan.acceleration_mps2)) {
            (Piece::Rest { duration_s }, _) => {
                rest(session, *duration_s, period_ms, &mut telemetry, &mut at).await?;
            }
            (_, Some(motion)) => {
                motion::drive_into(session, &motion, options.clone(), &mut telemetry, &mut at)
                    .await?;
            }
            (_, None) => {}
        }
        done_s += piece_s + 2.0 * PAUSE_S;
    }
    telemetry.sort_by_key(|frame| frame.t_us);
    let reckoned = reckoned(config, &telemetry);
    let track = match source.measure(&session.clock(), first, run, &reckoned).await? {
        Seen::Track(track) => track,
        Seen::Repeat => return Ok(RunOutcome::Repeat),
        Seen::Skip => return Ok(RunOutcome::Skip),
    };
    let rows = rows(&telemetry, &track, &source.yaw_rates(&run.name, &reckoned)?);
    if rows.len() < 2 {
        return Err(Error::new("the robot sent no telemetry during the run")
            .hint("`beeline watch` shows whether it sends any"));
    }
    let dropped = session.status().await?.link.telemetry_dropped.wrapping_sub(dropped_before);
    let rows = rows.iter().map(|row| on_one_encoder(row, config)).collect();
    Ok(RunOutcome::Recorded(RecordedRun { rows, started_us, dropped }))
}

/// Records the robot standing still.
async fn rest(
    session: &mut Session,
    duration_s: f64,
    period_ms: u16,
    telemetry: &mut Vec<Telemetry>,
    progress: &mut dyn FnMut(f64),
) -> Result<()> {
    const LISTEN_FOR: Duration = Duration::from_millis(100);
    let _stale = session.take_telemetry().count();
    session.request(Command::Subscribe { period_ms }).await?;
    let start_us = session.clock().now_us();
    loop {
        session.listen(LISTEN_FOR).await?;
        telemetry.extend(session.take_telemetry());
        let rested_s = (session.clock().now_us() - start_us) as f64 * 1e-6;
        progress((rested_s / duration_s).min(1.0));
        if session.is_cancelled() {
            let _ = session.ask(Command::Subscribe { period_ms: 0 }).await;
            return Err(Error::interrupted("stopped by Ctrl-C; the robot stands still"));
        }
        if rested_s >= duration_s {
            break;
        }
    }
    session.request(Command::Subscribe { period_ms: 0 }).await?;
    match session.status().await?.fault {
        Some(report) => Err(host_link::Error::Faulted(report).into()),
        None => Ok(()),
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
