//! `beeline record`

use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::json;
use shared_proto::{Config, Telemetry};
use sim_target::Lab;

use super::drive::{kind, motion_of};
use crate::campaign::{CampaignWriter, Column, RobotFile, Row, RunFacts};
use crate::cli::{Common, RecordArgs, period_ms};
use crate::error::{Error, Result};
use crate::hex::hex;
use crate::motion::{self, RecordOptions};
use crate::port::with_robot;
use crate::ui::{Progress, note, say, warn};

pub(super) fn run(common: &Common, args: &RecordArgs) -> Result<()> {
    let (path, rows) = with_robot(&common.port, &common.sim(), async |session, lab| {
        let config = session.read_config().await?;
        let motion = motion_of(&args.motion, &config)?;
        // Before the robot moves: a folder that cannot be written must not cost a run.
        let mut robot = robot_file(&config, lab.as_ref());
        // In the simulator, whoever asks for other noise asks for another seed, and so for another uid.
        if lab.is_none() {
            robot.uid = Some(hex(&session.identify().await?.uid));
        }
        let writer = CampaignWriter::open(&args.campaign, &robot)?;
        let name = args.name.as_deref().unwrap_or(kind(&args.motion));
        let mut run = writer.start_run(name, &columns(lab.is_some()))?;

        let progress = Progress::new(format!("recording {name}"), common.json);
        let period_ms = period_ms(args.rate);
        let options = RecordOptions { period_ms, camera: lab.clone(), ..RecordOptions::default() };
        let seen = lab.as_ref().map_or(0, Lab::camera_len);
        let dropped = session.status().await?.link.telemetry_dropped;
        // The host's clock is one for all runs, which the robot's is not: it begins anew at every power-on.
        // In the simulator each run is a new robot, and the same seed gives the same bytes.
        let started_s = if lab.is_none() { Some(unix_time_s()) } else { None };
        let mut telemetry = Vec::new();
        let driven = motion::drive_into(session, &motion, options, &mut telemetry, &mut |share| {
            progress.set(share);
        })
        .await;
        drop(progress);
        let rows = rows(&telemetry, lab.as_ref(), seen);
        if rows.len() < 2 {
            driven?;
            return Err(Error::new("the robot sent no telemetry during the motion"));
        }
        for row in &rows {
            run.push(row)?;
        }
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
        let lost = session.statistics().telemetry_lost;
        if lost > u64::from(dropped) {
            warn(format_args!("{} samples were lost on the line", lost - u64::from(dropped)));
        }
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

/// Seconds since 1970, to the millisecond.
fn unix_time_s() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    since.as_millis() as f64 * 1e-3
}

fn robot_file(config: &Config, lab: Option<&Lab>) -> RobotFile {
    let encoder = config.encoder.left;
    let name = match config.name.as_str() {
        "" => "unnamed robot",
        name => name,
    };
    RobotFile {
        name: name.into(),
        wheel_radius_m: config.geometry.wheel_radius_m,
        track_width_m: config.geometry.track_width_m,
        counts_per_rev: encoder.counts_per_rev,
        gear_reduction: encoder.gear_reduction,
        position_sigma_m: lab.map(|lab| lab.camera_parameters().position_sigma_m),
        heading_sigma_rad: lab.map(|lab| lab.camera_parameters().heading_sigma_rad),
        supply_v: None,
        uid: None,
        runs: Vec::new(),
    }
}

fn columns(poses: bool) -> Vec<Column> {
    let mut columns = vec![Column::LeftDuty, Column::RightDuty, Column::BusV];
    if poses {
        columns.extend([Column::X, Column::Y, Column::Heading]);
    }
    columns
}

/// Telemetry and camera samples in order of time; a camera sample gets a row of its own.
fn rows(telemetry: &[Telemetry], lab: Option<&Lab>, seen: usize) -> Vec<Row> {
    let (Some(first), Some(last)) = (telemetry.first(), telemetry.last()) else {
        return Vec::new();
    };
    let start_us = first.t_us;
    let mut rows: Vec<_> = telemetry
        .iter()
        .map(|frame| Row {
            t_s: (frame.t_us - start_us) as f64 * 1e-6,
            counts: frame.wheels.map(|wheel| Some(wheel.counts as f64)),
            duty: frame.wheels.map(|wheel| Some(f64::from(wheel.duty) / 32767.0)),
            bus_v: Some(f64::from(frame.supply_mv) * 1e-3),
            ..Row::default()
        })
        .collect();
    let end_s = (last.t_us - start_us) as f64 * 1e-6;
    for sample in lab.map(|lab| lab.camera_samples_from(seen)).unwrap_or_default() {
        let t_s = sample.s_since(start_us);
        if (0.0..=end_s).contains(&t_s) {
            let (x_m, y_m) = (Some(sample.x_m), Some(sample.y_m));
            rows.push(Row {
                t_s,
                x_m,
                y_m,
                heading_rad: Some(sample.heading_rad),
                ..Row::default()
            });
        }
    }
    rows.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    merge_equal_times(rows)
}

/// One row for each time: file times have microseconds, and increase.
fn merge_equal_times(rows: Vec<Row>) -> Vec<Row> {
    let mut merged: Vec<Row> = Vec::with_capacity(rows.len());
    for row in rows {
        match merged.last_mut() {
            Some(last) if (row.t_s - last.t_s) < 1e-6 => {
                last.counts.left = last.counts.left.or(row.counts.left);
                last.counts.right = last.counts.right.or(row.counts.right);
                last.duty.left = last.duty.left.or(row.duty.left);
                last.duty.right = last.duty.right.or(row.duty.right);
                last.bus_v = last.bus_v.or(row.bus_v);
                last.x_m = last.x_m.or(row.x_m);
                last.y_m = last.y_m.or(row.y_m);
                last.heading_rad = last.heading_rad.or(row.heading_rad);
            }
            _ => merged.push(row),
        }
    }
    merged
}
