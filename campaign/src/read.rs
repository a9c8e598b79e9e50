//! Reads campaign folders, with one clear error for each way in which they can be wrong.
//!
//! Whether a robot can have driven the runs is left to `checks`.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::duplicate_runs;
use crate::error::{CampaignError, Place, Warning};
use crate::recorded::{Campaign, Run};
use crate::robot_toml::{RobotFile, RunFacts, place_of_run};
use crate::row::{Column, Row};
use crate::table::Table;
use crate::to_recording::Recordings;

impl Campaign {
    /// Reads a campaign folder.
    pub fn read(folder: &Path) -> Result<Self, CampaignError> {
        Self::read_both(folder).map(|(campaign, _)| campaign)
    }

    /// Reads a campaign folder, both as in its files and as `robot-model` takes it: each run is
    /// converted once.
    pub fn read_both(folder: &Path) -> Result<(Self, Recordings), CampaignError> {
        let toml = folder.join("robot.toml");
        // The files first: the facts of a run are there before its file.
        let listed = run_files(folder);
        let mut robot = RobotFile::read(&toml)?;
        let RunFiles { files, warnings } = listed?;
        // A run that is not listed is about to appear, or has appeared since: it is for the next reading.
        let listed = |facts: &RunFacts| files.iter().any(|(name, _)| *name == facts.name);
        let appeared = |name: &str| folder.join("runs").join(format!("{name}.csv")).exists();
        robot.runs.retain(|facts| listed(facts) || !(facts.pending || appeared(&facts.name)));
        robot.runs.iter_mut().for_each(|facts| facts.pending = false);
        if files.is_empty() {
            let problem = "this campaign has no runs";
            let hint = "put at least one .csv file into its folder `runs`";
            return Err(CampaignError::new(Place::whole(folder), problem, hint));
        }
        let (runs, copies) = (Vec::new(), Vec::new());
        let mut campaign = Self { robot, runs, copies, warnings };
        for (name, file) in &files {
            let (rows, warnings) = read_run(file)?;
            let facts = campaign.robot.runs.iter().find(|facts| facts.name == *name).cloned();
            let facts =
                facts.unwrap_or_else(|| RunFacts { name: name.clone(), ..RunFacts::default() });
            campaign.runs.push(Run { name: name.clone(), facts, rows });
            campaign.warnings.extend(warnings);
        }
        if let Some(facts) = campaign
            .robot
            .runs
            .iter()
            .find(|facts| files.iter().all(|(name, _)| *name != facts.name))
        {
            let place = place_of_run(&toml, &facts.name);
            let problem = format!("the run `{}` does not exist", facts.name);
            let hint = format!("add the file runs/{}.csv, or remove this [[run]]", facts.name);
            return Err(CampaignError::new(place, problem, hint));
        }
        campaign.copies = duplicate_runs::take_out(&mut campaign.runs);
        campaign.warnings.extend(campaign.copied(folder));
        campaign.warnings.extend(campaign.without_start(&toml));
        let recordings = Recordings::of(&campaign);
        let odd = recordings.warnings(&campaign, folder);
        campaign.warnings.extend(odd);
        Ok((campaign, recordings))
    }

    /// Reads a folder that may have no runs yet.
    pub fn read_if_any(folder: &Path) -> Result<Option<Self>, CampaignError> {
        match Self::read(folder) {
            Ok(campaign) => Ok(Some(campaign)),
            Err(error) if error.place == Place::whole(folder) && error.cause.is_none() => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// A warning if runs are copies of others.
    fn copied(&self, folder: &Path) -> Option<Warning> {
        let (place, copies) = (Place::whole(&folder.join("runs")), self.copies.clone());
        (!copies.is_empty()).then_some(Warning::Copies { place, copies })
    }

    /// A warning if some runs that a model is fitted to do not say when they began: a drift with
    /// time cannot be fitted without it.
    fn without_start(&self, toml: &Path) -> Option<Warning> {
        let fitted = || self.runs.iter().filter(|run| !run.facts.held_out);
        let (of, told) =
            (fitted().count(), fitted().filter(|run| run.facts.started_s.is_some()).count());
        let place = Place::whole(toml);
        (of > 1 && told < of).then(|| Warning::NoStart { place, runs: of - told, of })
    }
}

/// The run files of a folder.
#[derive(Debug, Default)]
pub(super) struct RunFiles {
    /// By name, in order.
    pub files: Vec<(String, PathBuf)>,
    /// Those that look like runs and are none.
    pub warnings: Vec<Warning>,
}

/// The run files of a folder; none if there is no folder `runs`.
pub(super) fn run_files(folder: &Path) -> Result<RunFiles, CampaignError> {
    let runs = folder.join("runs");
    let mut found = RunFiles::default();
    if !runs.exists() {
        return Ok(found);
    }
    let fail = |error| CampaignError::io(&runs, "list it", error);
    for entry in fs::read_dir(&runs).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        let Some(extension) = path.extension() else { continue };
        if !extension.eq_ignore_ascii_case("csv") {
            continue;
        }
        match path.file_stem().and_then(|stem| stem.to_str()) {
            Some(name) if extension == "csv" => found.files.push((name.to_owned(), path)),
            _ => found.warnings.push(Warning::NotARun { place: Place::whole(&path) }),
        }
    }
    found.files.sort();
    found.warnings.sort_by_key(ToString::to_string);
    Ok(found)
}

/// Reads one run file.
pub fn read_run(file: &Path) -> Result<(Vec<Row>, Vec<Warning>), CampaignError> {
    rows_of(file, Table::read(file, Column::from_name, &Column::REQUIRED)?)
}

/// Reads the content of a run file; errors call it `file`.
pub fn parse_run(
    file: &Path,
    content: impl Read,
) -> Result<(Vec<Row>, Vec<Warning>), CampaignError> {
    rows_of(file, Table::parse(file, content, Column::from_name, &Column::REQUIRED)?)
}

fn rows_of(file: &Path, table: Table) -> Result<(Vec<Row>, Vec<Warning>), CampaignError> {
    check_positions(file, &table)?;
    let rows = table
        .rows
        .into_iter()
        .map(|(_, cells)| {
            let mut row = Row::default();
            for (column, value) in cells {
                row.set(column, value);
            }
            row
        })
        .collect();
    Ok((rows, table.warnings))
}

/// Refuses half a position, which would be ignored without a warning.
fn check_positions(file: &Path, table: &Table) -> Result<(), CampaignError> {
    let half = |line: u64, has: Column, lacks: Column| {
        let column = table.column(has).unwrap_or_default();
        let problem = format!("there is {} without {}", has.name(), lacks.name());
        let hint = "a position has both: fill in the other, or clear this one";
        CampaignError::new(Place { file: file.into(), line, column }, problem, hint)
    };
    for (has, lacks) in [(Column::X, Column::Y), (Column::Y, Column::X)] {
        if table.column(has).is_some() && table.column(lacks).is_none() {
            return Err(half(1, has, lacks));
        }
        for (line, cells) in &table.rows {
            let measured =
                |wanted| cells.iter().any(|(column, value)| *column == wanted && value.is_some());
            if measured(has) && !measured(lacks) {
                return Err(half(*line, has, lacks));
            }
        }
    }
    Ok(())
}
