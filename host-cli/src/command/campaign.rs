//! `beeline campaign plan` and `beeline campaign record`: options, progress and results.
//!
//! Runs are planned in `campaign`, and recorded by [`crate::campaign_recorder`].

use std::path::Path;

use serde_json::json;
use shared_proto::Config;

use super::pose_source;
use crate::campaign_recorder::{RecordSettings, RecordStep, Summary, record_campaign};
use crate::cli::{CampaignCommand, CampaignRecordArgs, Common, PlanArgs, PlanCommandArgs};
use crate::error::{Error, Result};
use crate::escape::{seen, shell_path};
use crate::port::with_robot;
use crate::ui::{self, BOLD, DIM, GOOD, Progress, note, paint, say, say_text, warn};
use campaign::Campaign;
use campaign::file::{check_writable, write_whole};
use campaign::plan::run_kinds::{ExtraRuns, fastest_mps, kinds, once_more, runs_of};
use campaign::plan::{CampaignPlan, Floor, PlanSettings, PlannedRun, plan_path};

pub(super) fn run(common: &Common, command: &CampaignCommand) -> Result<()> {
    match command {
        CampaignCommand::Plan(args) => plan(common, args),
        CampaignCommand::Record(args) => record(common, args),
    }
}

fn plan(common: &Common, args: &PlanCommandArgs) -> Result<()> {
    let mut config = Config::default();
    config.geometry.track_width_m = args.track_width.m;
    let plan = plan_of(&args.plan, &config)?;
    let track_width_m = args.track_width.m;
    plan.check_durations(track_width_m)?;
    match &args.output {
        Some(file) if file.as_os_str() == "-" && common.json => {
            return Err(Error::new("what `-o -` prints is TOML, no JSON")
                .hint("without -o, --json prints the plan as JSON"));
        }
        Some(file) if file.as_os_str() == "-" => {
            say_text(plan.to_toml().trim_end());
            return Ok(());
        }
        Some(file) => {
            check_writable(file).map_err(|error| {
                Error::new(format_args!("cannot write {}: {error}", file.display()))
                    .hint(error.hint("check the path"))
            })?;
            let text = plan.to_toml();
            let is_other = |there: Vec<u8>| there != text.as_bytes();
            if !args.force && file.is_file() && std::fs::read(file).is_ok_and(is_other) {
                return Err(Error::new(format_args!("{} exists", file.display()))
                    .hint("choose another name, or --force to replace it"));
            }
            write_whole(file, text.as_bytes()).map_err(|error| {
                Error::new(format_args!("cannot write {}: {error}", file.display()))
                    .hint(error.hint("check the path"))
            })?;
        }
        None => {}
    }
    if common.json {
        say(json!({
            "runs": plan.runs.iter().map(|run| to_json(run, &plan, track_width_m)).collect::<Vec<_>>(),
            "duration_s": plan.duration_s(track_width_m),
            "file": args.output,
        }));
        return Ok(());
    }
    say_text(table(&plan, track_width_m));
    match &args.output {
        Some(file) => note(format_args!(
            "written to {}: edit it, then `beeline campaign record FOLDER --plan {}`",
            file.display(),
            shell_path(file)
        )),
        None => note(
            "`-o plan.toml` writes this plan for editing; `beeline campaign record FOLDER` drives it",
        ),
    }
    Ok(())
}

/// The plan of these options, for a robot with this configuration.
fn plan_of(args: &PlanArgs, config: &Config) -> Result<CampaignPlan> {
    match &args.plan {
        Some(file) => Ok(CampaignPlan::read(file)?),
        None => Ok(CampaignPlan::usual(&settings_of(args, config))?),
    }
}

fn settings_of(args: &PlanArgs, config: &Config) -> PlanSettings {
    /// The share of the speed limit that leaves the speed loop some room.
    const SPEED_SHARE: f64 = 0.875;
    let (usual, radius_m, limits) =
        (PlanSettings::default(), config.geometry.wheel_radius_m, config.limits);
    let [slow_mps, fast_mps] = usual.speeds_mps;
    let fast_mps = args
        .fast
        .map_or(fast_mps.min(SPEED_SHARE * limits.speed_mps_max), |speed| speed.mps(radius_m));
    let slow_mps = args.slow.map_or(slow_mps.min(0.5 * fast_mps), |speed| speed.mps(radius_m));
    PlanSettings {
        floor_m: args.floor.map_or(usual.floor_m, |floor| floor.0),
        speeds_mps: [slow_mps, fast_mps],
        acceleration_mps2: args
            .acceleration
            .map_or(usual.acceleration_mps2.min(limits.acceleration_mps2_max), |acceleration| {
                acceleration.mps2(radius_m)
            }),
        repeats: args.repeats.unwrap_or(usual.repeats),
        payload_kg: args.payload.map_or(usual.payload_kg, |mass| mass.0),
        track_width_m: config.geometry.track_width_m,
    }
}

fn to_json(run: &PlannedRun, plan: &CampaignPlan, track_width_m: f64) -> serde_json::Value {
    json!({
        "name": run.name,
        "kind": run.kind,
        "heading_rad": run.heading_rad,
        "payload_kg": run.payload_kg,
        "held_out": run.held_out,
        "floor_m": Floor::of(&run.pieces, track_width_m).size_m(),
        "duration_s": run.duration_s(track_width_m, plan.acceleration_mps2),
        "shows": run.shows,
    })
}

fn table(plan: &CampaignPlan, track_width_m: f64) -> String {
    let line = |name: &str, way: &str, speed: &str, floor: &str, time: &str, shows: &str| {
        format!("{name:<24} {way:<22} {speed:>9} {floor:>11} {time:>6}  {shows}")
    };
    let head = line("run", "what it drives", "speed", "floor", "time", "what it shows");
    let mut lines = vec![paint(DIM, head.trim_end())];
    for run in &plan.runs {
        let [length_m, width_m] = Floor::of(&run.pieces, track_width_m).size_m();
        lines.push(line(
            &seen(&run.name),
            &motion_in_words(run),
            &speed(run),
            &format!("{length_m:.1} x {width_m:.1} m"),
            &format!("{:.0} s", run.duration_s(track_width_m, plan.acceleration_mps2)),
            &seen(&run.shows),
        ));
    }
    let floor = plan.floor(track_width_m);
    let minutes = plan.duration_s(track_width_m) / 60.0;
    lines.push(format!(
        "{} runs, {minutes:.0} minutes of driving; from its mark {:.1} m ahead, {:.1} m behind, {:.1} m to each side",
        plan.runs.len(),
        floor.ahead_m,
        floor.behind_m,
        floor.left_m.max(floor.right_m)
    ));
    lines.join("\n")
}

/// The first pieces of a run, as text.
fn motion_in_words(run: &PlannedRun) -> String {
    use robot_model::recording::Piece;
    let word = |piece: &Piece| match *piece {
        Piece::Straight { travel_m, .. } => format!("{travel_m:+.2} m"),
        Piece::Spin { turn_rad, .. } => format!("{:+.0} deg", turn_rad.to_degrees()),
        Piece::Arc { radius_m, turn_rad, .. } => {
            format!("{:+.0} deg, r {radius_m:.2} m", turn_rad.to_degrees())
        }
        Piece::Rest { duration_s } => format!("{duration_s} s"),
    };
    let mut words: Vec<String> = run.pieces.iter().take(2).map(word).collect();
    let first = &run.pieces[..2.min(run.pieces.len())];
    let repeats = run.pieces.chunks(2).all(|pair| pair == first);
    match run.pieces.len() {
        0..=2 => words.join(", "),
        n if repeats && n % 2 == 0 => format!("{}x ({})", n / 2, words.join(", ")),
        _ => {
            words.push("...".into());
            words.join(", ")
        }
    }
}

fn speed(run: &PlannedRun) -> String {
    use robot_model::recording::Piece;
    let speeds = run.pieces.iter().filter_map(|piece| match *piece {
        Piece::Straight { speed_mps, .. }
        | Piece::Spin { speed_mps, .. }
        | Piece::Arc { speed_mps, .. } => Some(speed_mps),
        Piece::Rest { .. } => None,
    });
    match speeds.reduce(f64::max) {
        Some(fastest) => format!("{fastest:.2} m/s"),
        None => String::new(),
    }
}

fn record(common: &Common, args: &CampaignRecordArgs) -> Result<()> {
    let folder = args.campaign.as_path();
    let summary = with_robot(&common.port, &common.sim(), async |session, testbed| {
        let config = session.read_config().await?;
        let mut source = pose_source::of_campaign(args, testbed)?;
        let (plan, settings) = what_to_record(args, &config, folder)?;
        let simulated = common.sim().simulated_robot(&common.port);
        let settings = RecordSettings { simulated, ..settings };
        let mut printer = ProgressPrinter { quiet: common.json, progress: None };
        record_campaign(session, &mut *source, &plan, folder, &settings, &mut |step| {
            printer.print(step);
        })
        .await
    })
    .map_err(|error| note_kept_runs(error, folder))?;
    finish(common, folder, &summary);
    Ok(())
}

/// Tells how much is kept of a campaign that ended early; returns the error.
fn note_kept_runs(error: Error, folder: &Path) -> Error {
    let runs =
        Campaign::read_if_any(folder).ok().flatten().map_or(0, |campaign| campaign.runs.len());
    if runs > 0 {
        note(format_args!(
            "{}: {} complete and kept; the same command continues with the next",
            folder.display(),
            ui::runs(runs)
        ));
    }
    error
}

fn what_to_record(
    args: &CampaignRecordArgs,
    config: &Config,
    folder: &Path,
) -> Result<(CampaignPlan, RecordSettings)> {
    let settings = RecordSettings {
        period_ms: (1000 / args.rate).max(1),
        position_sigma_m: args.position_sigma.map(|sigma| sigma.m),
        heading_sigma_rad: args.heading_sigma.map(|sigma| sigma.rad),
        ..RecordSettings::default()
    };
    if let Some(kind) = &args.run {
        let there = if folder.exists() { Campaign::read_if_any(folder)? } else { None };
        let taken = there.as_ref().map(Campaign::plain_names).unwrap_or_default();
        let mut asked = settings_of(&args.plan, config);
        if args.plan.fast.is_none()
            && let Some(mps) = there.as_ref().and_then(|campaign| fastest_mps(folder, campaign))
        {
            // `explain` plans with the same least speed for a campaign in which nothing moved.
            asked.speeds_mps[1] = mps.max(0.05).min(config.limits.speed_mps_max);
        }
        let ExtraRuns { plan, later_s } = match of_the_plan(kind, folder, &taken)? {
            Some(again) => again,
            None => runs_of(kind, &asked, &taken)?,
        };
        let runs_there = Some(taken.len());
        return Ok((plan, RecordSettings { whole: false, later_s, runs_there, ..settings }));
    }
    let begun = plan_path(folder);
    let plan = if !args.plan.any() && begun.exists() {
        CampaignPlan::read(&begun)?
    } else {
        plan_of(&args.plan, config)?
    };
    Ok((plan, settings))
}

/// A run of the folder's own plan once more, unless the name is that of a kind.
fn of_the_plan(name: &str, folder: &Path, taken: &[String]) -> Result<Option<ExtraRuns>> {
    let file = plan_path(folder);
    if kinds().contains(&name) || !file.exists() {
        return Ok(None);
    }
    Ok(once_more(name, &CampaignPlan::read(&file)?, taken))
}

/// Tells the user how far the campaign is.
struct ProgressPrinter {
    quiet: bool,
    progress: Option<(String, Progress)>,
}

impl ProgressPrinter {
    fn print(&mut self, step: RecordStep<'_>) {
        match step {
            RecordStep::Resumed(runs) if !self.quiet => {
                note(format_args!("already recorded: {} of the plan", ui::runs(runs)));
            }
            RecordStep::Started(index, of, run) => {
                let title = format!("{index:>2}/{of} {}", run.name);
                self.progress = Some((title.clone(), Progress::new(title, self.quiet)));
            }
            RecordStep::Driving(share) => {
                if let Some((_, progress)) = &self.progress {
                    progress.set(share);
                }
            }
            RecordStep::Recorded { samples, poses, dropped, .. } => {
                let title = self.progress.take().map(|(title, _)| title).unwrap_or_default();
                if !self.quiet {
                    note(format_args!("  {title:<32} {samples:>6} samples, {poses:>5} poses"));
                }
                if dropped > 0 {
                    warn(format_args!(
                        "{dropped} samples were dropped because the line is too slow: lower --rate, or raise the baud rate"
                    ));
                }
            }
            RecordStep::Skipped(run) => {
                self.progress = None;
                if !self.quiet {
                    note(format_args!("  {} skipped", run.name));
                }
            }
            RecordStep::Warning(warning) => warn(warning),
            RecordStep::FactsRestored(run) => warn(format_args!(
                "robot.toml had no [[run]] for {run}: its load, and whether it is held out, were restored from the plan; \
                 its started_s is not known"
            )),
            RecordStep::Compensated(effects) if !self.quiet => {
                let effects = effects.join(", ");
                note(format_args!(
                    "the robot already compensates {effects}: noted in model.toml as known"
                ));
            }
            RecordStep::CompensatedAnew(effect) => warn(format_args!(
                "the robot's {effect} differs from model.toml; counts are recorded raw, so old and new runs can be fitted together"
            )),
            RecordStep::Resumed(_) | RecordStep::Compensated(_) => {}
        }
    }
}

fn finish(common: &Common, folder: &Path, summary: &Summary) {
    if summary.without_poses > 0 {
        warn(format_args!(
            "{} without measured poses: add x_m, y_m and heading_rad to the files before you compare them",
            ui::runs(summary.without_poses)
        ));
    }
    if common.json {
        say(json!({
            "campaign": folder,
            "before": summary.before,
            "recorded": summary.recorded,
            "skipped": summary.skipped,
            "without_poses": summary.without_poses,
        }));
        return;
    }
    let runs = summary.recorded.len();
    if runs == 0 && summary.skipped.is_empty() {
        say(format_args!(
            "{} is complete: it has all {} of its plan",
            folder.display(),
            ui::runs(summary.before)
        ));
        return;
    }
    say(format_args!(
        "{} {}{}",
        paint(GOOD, format_args!("{}:", folder.display())),
        ui::runs(runs),
        match summary.before {
            0 => String::new(),
            before => format!(" recorded, {before} were there before"),
        }
    ));
    if !summary.skipped.is_empty() {
        say(format_args!(
            "  {} left out: {}; the same command asks again",
            paint(BOLD, summary.skipped.len()),
            summary.skipped.join(", ")
        ));
    }
}
