//! Experiments as runs of a campaign: counts, duties, supply, and the mean voltage between two rows.

use campaign::{CampaignWriter, Column, RobotFile, Row, RunFacts};
use shared_proto::{Config, Telemetry, WheelPair};

use super::experiments::DrivenExperiment;
use crate::campaign_recorder::{on_one_encoder, robot_file, seconds};
use crate::error::Result;

const COLUMNS: [Column; 5] =
    [Column::LeftDuty, Column::RightDuty, Column::BusV, Column::LeftV, Column::RightV];

/// The `robot.toml` of such a campaign.
pub fn robot_of(config: &Config) -> RobotFile {
    RobotFile { supply_v: Some(config.feedforward.nominal_v()), ..robot_file(config, None) }
}

/// Writes the experiments, one run each; times count from the first one.
pub fn write(
    writer: &CampaignWriter,
    config: &Config,
    driven: &[DrivenExperiment],
) -> Result<usize> {
    let first_us =
        driven.first().and_then(|one| one.telemetry.first()).map_or(0, |frame| frame.t_us);
    for experiment in driven {
        let Some(first) = experiment.telemetry.first() else { continue };
        let mut run = writer.start_run(experiment.name, &COLUMNS)?;
        for row in rows(&experiment.telemetry) {
            run.push(&on_one_encoder(&row, config))?;
        }
        let started_s = Some((seconds(first_us, first.t_us) * 1e3).round() / 1e3);
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
