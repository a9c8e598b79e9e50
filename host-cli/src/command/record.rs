//! `beeline record`: drives one motion and adds it to a campaign.

use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use ::import::export::Trajectory;
use robot_model::recording;
use serde_json::json;
use shared_proto::Config;

use super::drive::{kind, motion_of, profile_of};
use super::pose_source;
use crate::campaign_recorder::clock::LastRun;
use crate::campaign_recorder::record::recorded_meanwhile;
use crate::campaign_recorder::samples::{columns, on_one_encoder, robot_file, rows};
use crate::cli::{Common, RecordArgs, period_ms};
use crate::error::{Error, Result};
use crate::hex::hex;
use crate::limits;
use crate::port::{Port, with_robot};
use crate::ui::{Progress, note, say, warn};
use campaign::file::{check_writable, write_new};
use campaign::model::in_use;
use campaign::write::next_number;
use campaign::{Campaign, CampaignWriter, RobotFile, Row, Run, RunFacts};
use host_link::Session;
use host_link::motion::{self, RecordOptions};

pub(super) fn run(common: &Common, args: &RecordArgs) -> Result<()> {
    if let Some(bag) = &args.mcap {
        check_new_bag(bag)?;
    }
    let number = next_number(&args.campaign)?;
    let sim = common.sim().for_run(&common.port, number)?;
    let (path, rows, config) = with_robot(&common.port, &sim, async |session, testbed| {
        let config = session.read_config().await?;
        let motion = motion_of(&args.motion, &config)?;
        limits::check(&motion, &config, profile_of(&args.motion).long)?;
        let is_simulated = testbed.is_some();
        let mut source = pose_source::of_run(testbed);
        // Before the robot moves: a folder that cannot be written must not cost a run.
        let mut robot = robot_file(&config, source.noise());
        // A simulated robot has another uid with each seed, and still belongs to the same campaign.
        if !is_simulated {
            robot.uid = Some(hex(&session.identify().await?.uid));
        }
        robot.simulated = common.sim().simulated_robot(&common.port);
        let writer = CampaignWriter::open(&args.campaign, &robot)?;
        // The noise of a simulated run is that of its number.
        if is_simulated && next_number(&args.campaign)? != number {
            return Err(recorded_meanwhile(&args.campaign));
        }
        // The robot's own clock restarts at every power-on, so the start is on the campaign's. A
        // simulated run has none, so that the same seed gives the same bytes.
        let there = Campaign::read_if_any(&args.campaign)?;
        in_use::record(&args.campaign, writer.robot(), &config, there.is_some())?;
        let last = there.and_then(|campaign| LastRun::of(&args.campaign, &campaign));
        let now_s: f64 = last.map_or(0.0, |last| last.ended_s + last.ago_s);
        let started_s = (!is_simulated).then_some((now_s * 1e3).round() / 1e3);
        let name = args.name.as_deref().unwrap_or(kind(&args.motion));
        drop(writer.start_run(name, &[])?);

        let progress = Progress::new(format!("recording {name}"), common.json);
        let period_ms = period_ms(args.rate);
        let trigger = source.trigger();
        let options = RecordOptions { period_ms, trigger, ..RecordOptions::default() };
        let first = source.begin()?;
        let dropped = session.status().await?.link.telemetry_dropped;
        let mut telemetry = Vec::new();
        let driven = motion::drive_into(session, &motion, options, &mut telemetry, &mut |share| {
            progress.set(share);
        })
        .await;
        drop(progress);
        let track = source.poses_from(first)?;
        let gyro = source.yaw_rates(name, &[])?;
        let rows = rows(&telemetry, &track, &gyro);
        if rows.len() < 2 {
            driven?;
            return Err(Error::new("the robot sent no telemetry during the motion"));
        }
        let mut run =
            writer.start_run(name, &columns(source.measures_while_driving(), !gyro.is_empty()))?;
        for row in &rows {
            run.push(&on_one_encoder(row, &config))?;
        }
        let path = run.finish(RunFacts { started_s, ..RunFacts::default() })?;
        driven.inspect_err(|_| {
            let (path, samples) = (path.display(), rows.len());
            note(format_args!("{path}: kept up to this point, {samples} samples"));
        })?;
        warn_of_gaps(session, dropped).await?;
        Ok((path, rows, config))
    })?;
    finish(common, args, (&path, &rows), &config)
}

/// Says what was recorded, once it is, and writes the bag.
fn finish(
    common: &Common,
    args: &RecordArgs,
    (path, rows): (&Path, &[Row]),
    config: &Config,
) -> Result<()> {
    if !rows.iter().any(|row| row.x_m.is_some()) {
        warn("the run has no measured poses: add x_m, y_m and heading_rad before you compare it");
    }
    if let Some(bag) = &args.mcap {
        // A simulated run has no date, so that the same seed gives the same bytes.
        let is_simulated = matches!(common.port, Port::Sim(_));
        write_bag(bag, path, rows, config, !is_simulated).inspect_err(|_| {
            note(format_args!("{}: recorded, {} samples", path.display(), rows.len()));
        })?;
        note(format_args!("{} written", bag.display()));
    }
    say_recorded(common.json, path, rows.len());
    Ok(())
}

/// Refuses a bag that exists or cannot be written, before the robot moves.
fn check_new_bag(bag: &Path) -> Result<()> {
    if bag.exists() {
        return Err(
            Error::new(format_args!("{} exists", bag.display())).hint("choose another file")
        );
    }
    check_writable(bag).map_err(|error| bag_unwritten(bag, &error).hint(error.hint(BAG_HINT)))
}

const BAG_HINT: &str = "choose another file with --mcap; `beeline export --to mcap` makes a bag of a campaign at any time";

fn bag_unwritten(bag: &Path, error: &dyn std::fmt::Display) -> Error {
    Error::new(format_args!("cannot write {}: {error}", bag.display())).hint(BAG_HINT)
}

/// Writes a run that has just ended as a bag; `dated`: its stamps are the time of day.
fn write_bag(bag: &Path, run: &Path, rows: &[Row], config: &Config, dated: bool) -> Result<()> {
    let name = run.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let facts = RunFacts { name: name.clone(), ..RunFacts::default() };
    let rows: Vec<Row> = rows.iter().map(|row| on_one_encoder(row, config)).collect();
    let robot = RobotFile::of(config);
    let run = Run { name, facts, rows };
    let mut recording = run.to_recording(&robot);
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let began_s = since_1970.as_secs_f64() - recording.duration_s();
    recording.started_s = Some(if dated { began_s } else { 0.0 });
    let model = recording::Campaign { robot: robot.to_model(), runs: vec![recording] };
    let geometry = &config.geometry;
    let radii_m = [geometry.wheel_radius_m, geometry.wheel_radius_m * geometry.wheel_weight];
    let mut trajectories = Trajectory::all(&model, radii_m, geometry.track_width_m);
    Trajectory::add_telemetry(&mut trajectories, &[run]);
    let bytes = ::import::export::bag(&trajectories).map_err(|error| bag_unwritten(bag, &error))?;
    let written = write_new(bag, &bytes);
    match written.map_err(|error| bag_unwritten(bag, &error))? {
        true => Ok(()),
        false => Err(bag_unwritten(bag, &"somebody else has written it meanwhile")),
    }
}

fn say_recorded(json: bool, path: &Path, samples: usize) {
    if json {
        say(json!({"run": path, "samples": samples}));
    } else {
        say(format_args!("{}: {samples} samples", path.display()));
    }
}

/// Warns of missing samples; `dropped_before` is how many the robot had dropped before the run.
async fn warn_of_gaps(session: &mut Session, dropped_before: u32) -> Result<()> {
    let dropped = session.status().await?.link.telemetry_dropped.wrapping_sub(dropped_before);
    let lost = session.statistics().telemetry_lost;
    if lost > u64::from(dropped) {
        warn(format_args!("{} samples were lost on the line", lost - u64::from(dropped)));
    }
    if dropped > 0 {
        warn(format_args!(
            "{dropped} samples were dropped because the line is too slow: lower --rate, or raise the baud rate"
        ));
    }
    Ok(())
}
