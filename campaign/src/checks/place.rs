//! Where in the files something is that is reported of a run, or of all.

use std::fs;
use std::path::{Path, PathBuf};

use robot_model::checks::DataHypothesis;

use crate::error::Place;
use crate::recorded::{Campaign, Run};
use crate::robot_toml::place_of_key;
use crate::row::Column;

/// Where something is that is reported of a run, or of all.
pub(super) struct Told<'a> {
    folder: &'a Path,
    /// What is wrong with a column is wrong in all runs: the first one stands for them.
    pub(super) run: Option<&'a Run>,
}

impl<'a> Told<'a> {
    pub(super) fn new(folder: &'a Path, campaign: &'a Campaign, found: &DataHypothesis) -> Self {
        let of = |run: &&Run| found.run.as_ref().is_none_or(|name| *name == run.name);
        Self { folder, run: campaign.runs.iter().find(of) }
    }

    pub(super) fn file(&self) -> PathBuf {
        run_file(self.folder, self.run.map_or("", |run| run.name.as_str()))
    }

    /// A column's name.
    pub(super) fn header(&self, column: Column) -> Place {
        header(&self.file(), column)
    }

    /// A column in the first row from a time on.
    pub(super) fn cell(&self, t_s: f64, column: Column) -> Place {
        self.run.map_or_else(|| self.header(column), |run| cell(&self.file(), run, t_s, column))
    }

    /// A key of robot.toml.
    pub(super) fn key(&self, key: &str) -> Place {
        place_of_key(&self.folder.join("robot.toml"), key)
    }
}

pub(super) fn run_file(folder: &Path, name: &str) -> PathBuf {
    folder.join("runs").join(format!("{name}.csv"))
}

/// The first row from a time on; the first one of all has line 2.
pub(super) fn line(run: &Run, t_s: f64) -> u64 {
    run.rows.iter().position(|row| row.t_s >= t_s).unwrap_or(0) as u64 + 2
}

pub(super) fn cell(file: &Path, run: &Run, t_s: f64, column: Column) -> Place {
    Place { line: line(run, t_s), ..header(file, column) }
}

/// The place of a column's name; the whole file if it cannot be read again.
pub(super) fn header(file: &Path, column: Column) -> Place {
    let text = fs::read_to_string(file).unwrap_or_default();
    let names = text.lines().next().unwrap_or_default().split(',');
    let name =
        |cell: &str| cell.trim().trim_start_matches('\u{feff}').trim_matches('"') == column.name();
    match names.into_iter().position(name) {
        Some(index) => Place { line: 1, column: index as u64 + 1, ..Place::whole(file) },
        None => Place::whole(file),
    }
}
