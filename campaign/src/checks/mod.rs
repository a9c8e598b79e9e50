//! What is wrong with the data of a campaign, where, and what to do: `robot-model` finds it, and `words` has the
//! sentences.
//!
//! What a fit cannot live with is an error, told when the campaign is to be fitted; the rest are warnings.

use std::path::{Path, PathBuf};

use robot_model::checks::{DataHypothesis, What, heading_offset, slow_clock, spike};
use robot_model::recording::Recording;

use crate::error::{CampaignError, Place, Warning};
use crate::recorded::{Campaign, Run};
use crate::robot_toml::place_of_key;
use crate::row::Column;
use crate::to_recording::Recordings;

mod words;

/// Refuses a campaign whose data cannot be fitted, by the best hypothesis.
pub(crate) fn check(
    folder: &Path,
    campaign: &Campaign,
    found: &[DataHypothesis],
) -> Result<(), CampaignError> {
    match found.iter().find(|found| !found.what.is_minor()) {
        Some(best) => Err(words::error(folder, campaign, best, found)),
        None => Ok(()),
    }
}

/// What is odd about a campaign's runs without being an error.
pub(crate) fn warnings(
    folder: &Path,
    campaign: &Campaign,
    recordings: &Recordings,
) -> Vec<Warning> {
    let runs = &recordings.runs;
    if runs.iter().any(|recording| recording.validate().is_err()) {
        return Vec::new();
    }
    let mut warnings = slow_clocks(folder, campaign, runs);
    let found = &recordings.data_hypotheses;
    // With something wrong in all runs, no other check means anything.
    if found.iter().all(|found| found.what.is_minor() || found.run.is_some()) {
        warnings.extend(rows_and_headings(folder, campaign, recordings));
        let minor = found.iter().filter(|found| found.what.is_minor());
        warnings.extend(minor.map(|found| warning(folder, campaign, found)));
    }
    warnings
}

/// What a fit can live with.
fn warning(folder: &Path, campaign: &Campaign, found: &DataHypothesis) -> Warning {
    let of = Told::new(folder, campaign, found);
    match found.what {
        What::CountsJump { wheel, t_s, rolled_m } => {
            Warning::CountsJump { place: of.cell(t_s, words::counts(wheel)), rolled_m }
        }
        What::LastPose { t_s, position_m, heading_rad } => {
            let column = if position_m.is_some() { Column::X } else { Column::Heading };
            Warning::EndPoseOff { place: of.cell(t_s, column), position_m, heading_rad }
        }
        What::CountsHeld { every_s } => Warning::Held {
            place: of.header(Column::LeftCounts),
            columns: "left_counts and right_counts",
            every_s,
        },
        What::PosesHeld { every_s } => Warning::Held {
            place: of.header(Column::X),
            columns: "x_m, y_m and heading_rad",
            every_s,
        },
        _ if found.run.is_none() => Warning::ManyRunsOff { place: of.key("wheel_radius_m") },
        _ => Warning::MostPosesOff { place: of.header(Column::X), off_m: found.error_m },
    }
}

/// Single positions that no robot reached, and a heading offset that all runs share.
fn rows_and_headings(folder: &Path, campaign: &Campaign, recordings: &Recordings) -> Vec<Warning> {
    let robot = &recordings.robot;
    let row = |(run, recording): (&Run, &Recording)| {
        let found = spike(robot, recording)?;
        let place = cell(&run_file(folder, &run.name), run, found.t_s, Column::X);
        Some(Warning::Spike { place, off_m: found.off_m })
    };
    let mut warnings: Vec<Warning> =
        campaign.runs.iter().zip(&recordings.runs).filter_map(row).collect();
    if let Some(turned_rad) = heading_offset(robot, &recordings.runs) {
        let first = campaign.runs.first().map_or("", |run| run.name.as_str());
        let place = header(&run_file(folder, first), Column::Heading);
        warnings.push(Warning::HeadingOffset { place, turned_rad });
    }
    warnings
}

/// Runs whose clock can hardly be in seconds.
fn slow_clocks(folder: &Path, campaign: &Campaign, runs: &[Recording]) -> Vec<Warning> {
    let warning = |(run, recording): (&Run, &Recording)| {
        let found = slow_clock(recording)?;
        let place = header(&run_file(folder, &run.name), Column::Time);
        Some(Warning::Clock { place, rate_rad_s: found.rate_rad_s, per_s: found.per_s })
    };
    campaign.runs.iter().zip(runs).filter_map(warning).collect()
}

/// Where something is that is told of a run, or of all.
struct Told<'a> {
    folder: &'a Path,
    /// What is wrong with a column is wrong in all runs: the first one stands for them.
    run: Option<&'a Run>,
}

impl<'a> Told<'a> {
    fn new(folder: &'a Path, campaign: &'a Campaign, found: &DataHypothesis) -> Self {
        let of = |run: &&Run| found.run.as_ref().is_none_or(|name| *name == run.name);
        Self { folder, run: campaign.runs.iter().find(of) }
    }

    fn file(&self) -> PathBuf {
        run_file(self.folder, self.run.map_or("", |run| run.name.as_str()))
    }

    /// A column's name.
    fn header(&self, column: Column) -> Place {
        header(&self.file(), column)
    }

    /// A column in the first row from a time on.
    fn cell(&self, t_s: f64, column: Column) -> Place {
        self.run.map_or_else(|| self.header(column), |run| cell(&self.file(), run, t_s, column))
    }

    /// A key of robot.toml.
    fn key(&self, key: &str) -> Place {
        place_of_key(&self.folder.join("robot.toml"), key)
    }
}

fn run_file(folder: &Path, name: &str) -> PathBuf {
    folder.join("runs").join(format!("{name}.csv"))
}

/// The first row from a time on; the first one of all has line 2.
fn line(run: &Run, t_s: f64) -> u64 {
    run.rows.iter().position(|row| row.t_s >= t_s).unwrap_or(0) as u64 + 2
}

fn cell(file: &Path, run: &Run, t_s: f64, column: Column) -> Place {
    Place { line: line(run, t_s), ..header(file, column) }
}

/// The place of a column's name; the whole file if it cannot be read again.
fn header(file: &Path, column: Column) -> Place {
    let text = std::fs::read_to_string(file).unwrap_or_default();
    let names = text.lines().next().unwrap_or_default().split(',');
    let name =
        |cell: &str| cell.trim().trim_start_matches('\u{feff}').trim_matches('"') == column.name();
    match names.into_iter().position(name) {
        Some(index) => Place { line: 1, column: index as u64 + 1, ..Place::whole(file) },
        None => Place::whole(file),
    }
}

#[cfg(test)]
mod tests;
