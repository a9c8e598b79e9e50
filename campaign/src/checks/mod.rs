//! What is wrong with the data of a campaign, where, and what to do: `robot-model` finds it, and `words` has the
//! sentences.
//!
//! What a fit cannot live with is an error, told when the campaign is to be fitted; the rest are warnings.

use std::path::Path;

use robot_model::checks::{DataFault, DataHypothesis, clock_jump, slow_clock, spike};
use robot_model::recording::{Recording, Robot};

use crate::error::{CampaignError, Warning};
use crate::recorded::{Campaign, Run};
use crate::row::Column;

mod noise;
mod place;
mod words;

use place::{FaultPlaces, cell, header, run_file};

/// Refuses a campaign whose data cannot be fitted, by the best hypothesis; then one whose noise is not as stated.
pub(crate) fn check(
    folder: &Path,
    campaign: &Campaign,
    (robot, runs): (&Robot, &[Recording]),
    found: &[DataHypothesis],
) -> Result<(), CampaignError> {
    clocks_go_on(folder, campaign, runs)?;
    match found.iter().find(|found| !found.what.is_minor()) {
        Some(best) => Err(words::error(folder, campaign, best, found)),
        None => noise::check(folder, robot, runs),
    }
}

/// What is wrong with the data, in words.
pub(crate) fn data_errors(
    folder: &Path,
    campaign: &Campaign,
    found: &[DataHypothesis],
) -> Vec<CampaignError> {
    found.iter().map(|one| words::error(folder, campaign, one, found)).collect()
}

/// What is odd about a campaign's runs without being an error.
pub(crate) fn warnings(
    folder: &Path,
    campaign: &Campaign,
    (robot, runs): (&Robot, &[Recording]),
    found: &[DataHypothesis],
    turned_rad: Option<f64>,
) -> Vec<Warning> {
    if runs.iter().any(|recording| recording.validate().is_err()) {
        return Vec::new();
    }
    let mut warnings = slow_clocks(folder, campaign, runs);
    // With something wrong in all runs, no other check means anything.
    if found.iter().all(|found| found.what.is_minor() || found.run.is_some()) {
        warnings.extend(spikes(folder, campaign, (robot, runs)));
        warnings.extend(turned_rad.map(|turned_rad| headings_turned(folder, campaign, turned_rad)));
        let minor = found.iter().filter(|found| found.what.is_minor());
        warnings.extend(minor.map(|found| warning(folder, campaign, found)));
    }
    warnings
}

/// What a fit can live with.
fn warning(folder: &Path, campaign: &Campaign, found: &DataHypothesis) -> Warning {
    let of = FaultPlaces::new(folder, campaign, found);
    match found.what {
        DataFault::CountsJump { wheel, t_s, rolled_m } => {
            Warning::CountsJump { place: of.cell(t_s, words::counts(wheel)), rolled_m }
        }
        DataFault::LastPose { t_s, position_m, heading_rad } => {
            let column = if position_m.is_some() { Column::X } else { Column::Heading };
            Warning::EndPoseOff { place: of.cell(t_s, column), position_m, heading_rad }
        }
        DataFault::CountsHeld { every_s } => Warning::Held {
            place: of.header(Column::LeftCounts),
            columns: "left_counts and right_counts",
            every_s,
        },
        DataFault::PosesHeld { every_s } => Warning::Held {
            place: of.header(Column::X),
            columns: "x_m, y_m and heading_rad",
            every_s,
        },
        _ if found.run.is_none() => Warning::ManyRunsOff { place: of.key("wheel_radius_m") },
        _ => Warning::MostPosesOff { place: of.header(Column::X), off_m: found.error_m },
    }
}

/// Single positions that no robot reached.
fn spikes(
    folder: &Path,
    campaign: &Campaign,
    (robot, runs): (&Robot, &[Recording]),
) -> Vec<Warning> {
    let row = |(run, recording): (&Run, &Recording)| {
        let found = spike(robot, recording)?;
        let place = cell(&run_file(folder, &run.name), run, found.t_s, Column::X);
        Some(Warning::Spike { place, off_m: found.off_m })
    };
    campaign.runs.iter().zip(runs).filter_map(row).collect()
}

/// A heading offset that all runs share.
fn headings_turned(folder: &Path, campaign: &Campaign, turned_rad: f64) -> Warning {
    let first = campaign.runs.first().map_or("", |run| run.name.as_str());
    let place = header(&run_file(folder, first), Column::Heading);
    Warning::HeadingOffset { place, turned_rad }
}

/// Refuses a run whose clock jumps: every speed and every pose after it would be wrong.
fn clocks_go_on(
    folder: &Path,
    campaign: &Campaign,
    runs: &[Recording],
) -> Result<(), CampaignError> {
    for (run, recording) in campaign.runs.iter().zip(runs) {
        if let Some(found) = clock_jump(recording) {
            let place = cell(&run_file(folder, &run.name), run, found.t_s, Column::Time);
            return Err(words::clock_jump(place, found.jump_s));
        }
    }
    Ok(())
}

/// Runs whose clock can hardly be in seconds.
fn slow_clocks(folder: &Path, campaign: &Campaign, runs: &[Recording]) -> Vec<Warning> {
    let warning = |(run, recording): (&Run, &Recording)| {
        let found = slow_clock(recording)?;
        let place = header(&run_file(folder, &run.name), Column::Time);
        let (rate_rad_s, per_s) = (found.rate_rad_s, found.per_s);
        Some(Warning::Clock { place, rate_rad_s, per_s })
    };
    campaign.runs.iter().zip(runs).filter_map(warning).collect()
}

#[cfg(test)]
mod examples;
#[cfg(test)]
mod tests;
