//! `beeline record`

use serde_json::json;
use sim_target::Lab;

use super::drive::{kind, motion_of};
use crate::campaign::{CampaignWriter, RunFacts};
use crate::cli::{Common, RecordArgs};
use crate::error::{Error, Result};
use crate::motion::{self, RecordOptions};
use crate::port::with_robot;
use crate::survey::samples::{camera_track, columns, robot_file, rows};
use crate::ui::{Progress, note, say, warn};

pub(super) fn run(common: &Common, args: &RecordArgs) -> Result<()> {
    let (path, rows) = with_robot(&common.port, &common.sim(), async |session, lab| {
        let config = session.read_config().await?;
        let motion = motion_of(&args.motion, &config)?;
        // Before the robot moves: a folder that cannot be written must not cost a run.
        let robot = robot_file(&config, lab.as_ref());
        let writer = CampaignWriter::open(&args.campaign, &robot)?;
        let name = args.name.as_deref().unwrap_or(kind(&args.motion));
        let mut run = writer.start_run(name, &columns(lab.is_some(), false))?;

        let progress = Progress::new(format!("recording {name}"), common.json);
        let period_ms = (1000 / args.rate).max(1);
        let options = RecordOptions { period_ms, ..RecordOptions::default() };
        let seen = lab.as_ref().map_or(0, Lab::camera_len);
        let dropped = session.status().await?.link.telemetry_dropped;
        let mut telemetry = Vec::new();
        let driven = motion::drive_into(session, &motion, options, &mut telemetry, &mut |share| {
            progress.set(share);
        })
        .await;
        drop(progress);
        let track = lab.as_ref().map(|lab| camera_track(lab, seen)).unwrap_or_default();
        let rows = rows(&telemetry, &track, &[]);
        if rows.len() < 2 {
            driven?;
            return Err(Error::new("the robot sent no telemetry during the motion"));
        }
        for row in &rows {
            run.push(row)?;
        }
        // Time since power-on is one clock for all runs, except in the simulator, where each run is a new robot.
        let started_s =
            telemetry.first().filter(|_| lab.is_none()).map(|frame| frame.t_us as f64 * 1e-6);
        let path = run.finish(RunFacts { started_s, ..RunFacts::default() })?;
        if let Err(error) = driven {
            note(format_args!(
                "{}: the run as far as it came, {} samples",
                path.display(),
                rows.len()
            ));
            return Err(error);
        }
        let dropped = session.status().await?.link.telemetry_dropped.wrapping_sub(dropped);
        if dropped > 0 {
            warn(format_args!(
                "the line was too slow for {dropped} samples: lower --rate, or raise the baud rate"
            ));
        }
        Ok((path, rows))
    })?;
    if !rows.iter().any(|row| row.x_m.is_some()) {
        warn("the run has no measured poses: add x_m, y_m and heading_rad before you compare it");
    }
    if common.json {
        say(json!({"run": path, "samples": rows.len()}));
    } else {
        say(format_args!("{}: {} samples", path.display(), rows.len()));
    }
    Ok(())
}
