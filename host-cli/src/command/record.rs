//! `beeline record`: drives one motion and adds it to a campaign.

use std::path::Path;

use serde_json::json;

use super::drive::{kind, motion_of, profile_of};
use super::pose_source;
use crate::campaign_recorder::clock::LastRun;
use crate::campaign_recorder::record::recorded_meanwhile;
use crate::campaign_recorder::samples::{columns, on_one_encoder, robot_file, rows};
use crate::cli::{Common, RecordArgs, period_ms};
use crate::error::{Error, Result};
use crate::hex::hex;
use crate::limits;
use crate::port::with_robot;
use crate::ui::{Progress, note, say, warn};
use campaign::model::in_use;
use campaign::write::next_number;
use campaign::{Campaign, CampaignWriter, RunFacts};
use host_link::Session;
use host_link::motion::{self, RecordOptions};

pub(super) fn run(common: &Common, args: &RecordArgs) -> Result<()> {
    let number = next_number(&args.campaign)?;
    let sim = common.sim().for_run(&common.port, number)?;
    let (path, rows) = with_robot(&common.port, &sim, async |session, lab| {
        let config = session.read_config().await?;
        let motion = motion_of(&args.motion, &config)?;
        limits::check(&motion, &config, profile_of(&args.motion).long)?;
        let is_simulated = lab.is_some();
        let mut source = pose_source::of_run(lab);
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
        Ok((path, rows))
    })?;
    if !rows.iter().any(|row| row.x_m.is_some()) {
        warn("the run has no measured poses: add x_m, y_m and heading_rad before you compare it");
    }
    say_recorded(common.json, &path, rows.len());
    Ok(())
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
