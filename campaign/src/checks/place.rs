//! Where in the files a reported value stands: of one run, or of all.

use std::io::Read;
use std::path::{Path, PathBuf};

use robot_model::checks::DataHypothesis;

use crate::bounded_read::{self, TABLE_BYTES_MAX};
use crate::error::Place;
use crate::recorded::{Campaign, Run};
use crate::robot_toml::place_of_key;
use crate::row::Column;

/// More than a header line takes.
const HEADER_BYTES: u64 = 1 << 16;

/// Where something is that is reported of a run, or of all.
pub(super) struct FaultPlaces<'a> {
    folder: &'a Path,
    /// What is wrong with a column is wrong in all runs: the first one stands for them.
    pub(super) run: Option<&'a Run>,
}

impl<'a> FaultPlaces<'a> {
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
        self::key(self.folder, key)
    }
}

/// A key of robot.toml.
pub(super) fn key(folder: &Path, key: &str) -> Place {
    place_of_key(&folder.join("robot.toml"), key)
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
    let mut head = Vec::new();
    let read = bounded_read::open(file, TABLE_BYTES_MAX)
        .map(|file| file.take(HEADER_BYTES).read_to_end(&mut head));
    let text = match read {
        Ok(Ok(_)) => String::from_utf8_lossy(&head),
        _ => return Place::whole(file),
    };
    let names = text.lines().next().unwrap_or_default().split(',');
    let name =
        |cell: &str| cell.trim().trim_start_matches('\u{feff}').trim_matches('"') == column.name();
    match names.into_iter().position(name) {
        Some(index) => Place { line: 1, column: index as u64 + 1, ..Place::whole(file) },
        None => Place::whole(file),
    }
}
