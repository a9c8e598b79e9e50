//! Experiments as runs of a campaign: counts, duties, supply, and the mean voltage between two rows.

use std::path::Path;

use campaign::{Campaign, CampaignWriter, Column, RobotFile, Row, RunFacts};
use shared_proto::{Config, Telemetry, WheelPair};

use super::experiments::DrivenExperiment;
use crate::campaign_recorder::clock::{CampaignClock, LastRun};
use crate::campaign_recorder::{on_one_encoder, robot_file, seconds};
use crate::error::Result;

const COLUMNS: [Column; 5] =
    [Column::LeftDuty, Column::RightDuty, Column::BusV, Column::LeftV, Column::RightV];

/// The `robot.toml` of such a campaign.
pub fn robot_of(config: &Config) -> RobotFile {
    RobotFile { supply_v: Some(config.feedforward.nominal_v()), ..robot_file(config, None) }
}

/// A simulated robot is new in each process: so long it is taken to have stood since the campaign's last run \[s\].
const PAUSE_S: f64 = 60.0;

/// The clock of a campaign that is continued; none for a new one. `robot_us` is the robot's time now.
pub fn clock_of(folder: &Path, is_simulated: bool, robot_us: u64) -> Result<Option<CampaignClock>> {
    if !folder.join("runs").is_dir() {
        return Ok(None);
    }
    let last = LastRun::of(folder, &Campaign::read(folder)?);
    Ok(last.map(|last| {
        let pause_s = if is_simulated { PAUSE_S } else { last.ago_s };
        CampaignClock::new(last.ended_s + pause_s, robot_us)
    }))
}

/// How many runs a folder has already.
pub fn runs_in(folder: &Path) -> Result<usize> {
    if !folder.join("runs").is_dir() {
        return Ok(0);
    }
    Ok(Campaign::read(folder)?.runs.len())
}

/// Writes the experiments, one run each; without a clock times count from the first one.
pub fn write(
    writer: &CampaignWriter,
    clock: Option<CampaignClock>,
    config: &Config,
    driven: &[DrivenExperiment],
) -> Result<usize> {
    let first_us =
        driven.first().and_then(|one| one.telemetry.first()).map_or(0, |frame| frame.t_us);
    let clock = clock.unwrap_or(CampaignClock::new(0.0, first_us));
    for experiment in driven {
        let Some(first) = experiment.telemetry.first() else { continue };
        let mut run = writer.start_run(experiment.name, &COLUMNS)?;
        for row in rows(&experiment.telemetry) {
            run.push(&on_one_encoder(&row, config))?;
        }
        let started_s = Some((clock.at(first.t_us) * 1e3).round() / 1e3);
        run.finish(RunFacts { started_s, ..RunFacts::default() })?;
    }
    Ok(driven.len())
}

/// The rows of one experiment.
pub fn rows(telemetry: &[Telemetry]) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::with_capacity(telemetry.len());
    let mut before: Option<&Telemetry> = None;
    for frame in telemetry {
        let first_us = telemetry[0].t_us;
        let applied_v = match before {
            None => WheelPair::both(0.0),
            Some(before) => {
                let dt_s = seconds(before.t_us, frame.t_us);
                if dt_s < 1e-6 {
                    continue;
                }
                before.wheels.zip(frame.wheels).map(|(before, now)| {
                    now.applied_uvs.wrapping_sub(before.applied_uvs) as f64 * 1e-6 / dt_s
                })
            }
        };
        rows.push(Row {
            t_s: seconds(first_us, frame.t_us),
            counts: frame.wheels.map(|wheel| Some(wheel.counts as f64)),
            duty: frame.wheels.map(|wheel| Some(f64::from(wheel.duty) / 32767.0)),
            bus_v: Some(f64::from(frame.supply_mv) * 1e-3),
            applied_v: applied_v.map(Some),
            ..Row::default()
        });
        before = Some(frame);
    }
    rows
}
