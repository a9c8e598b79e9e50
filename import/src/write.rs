//! Writes what was understood as a campaign folder.

use std::fs;
use std::path::{Path, PathBuf};

use campaign::file::sync_folder;
use campaign::new_folders::NewFolders;
use campaign::{CampaignError, CampaignWriter, Column, RobotFile, Row, RunFacts};

use robot_model::recording::Recording;

use crate::log::error;
use crate::understand::Understood;

/// Writes a campaign; the names of its runs.
///
/// A new folder appears whole or not at all. In one that exists, each run does, and it must have no runs yet unless
/// `is_adding`.
pub fn write(
    understood: &Understood,
    folder: &Path,
    is_adding: bool,
) -> Result<Vec<String>, CampaignError> {
    if folder.exists() {
        if !is_adding && has_runs(folder) {
            let hint = "choose another folder with -o, or add these runs to its own with --add";
            return Err(error(folder, "this campaign has runs already", hint));
        }
        return into(understood, folder);
    }
    let parent = match folder.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let cannot = |cause| CampaignError::io(folder, "make this folder", cause);
    let _made = NewFolders::make(parent).map_err(cannot)?;
    let beside = tempfile::Builder::new().prefix(".import-").tempdir_in(parent).map_err(cannot)?;
    let new = beside.path().join("campaign");
    let names = into(understood, &new)?;
    fs::rename(&new, folder).and_then(|()| sync_folder(folder)).map_err(cannot)?;
    Ok(names)
}

fn into(understood: &Understood, folder: &Path) -> Result<Vec<String>, CampaignError> {
    let writer = CampaignWriter::open(folder, &understood.robot)?;
    let rad_per_count = understood.robot.to_model().rad_per_count;
    let mut names = Vec::new();
    for run in &understood.runs {
        let mut columns = vec![Column::X, Column::Y, Column::Heading];
        columns.extend((!run.recording.gyro.is_empty()).then_some(Column::GyroZ));
        columns.extend((!run.supply_v.is_empty()).then_some(Column::BusV));
        let mut file = writer.start_run(&run.name, &columns)?;
        for row in rows(&run.recording, &run.supply_v, rad_per_count) {
            file.push(&row)?;
        }
        let facts = RunFacts { started_s: Some(run.started_s), ..RunFacts::default() };
        let path: PathBuf = file.finish(facts)?;
        names.push(
            path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned()),
        );
    }
    Ok(names)
}

/// Whether there is any run.
fn has_runs(folder: &Path) -> bool {
    let files = fs::read_dir(folder.join("runs")).into_iter().flatten().flatten();
    files.map(|file| file.path()).any(|file| file.extension().is_some_and(|ending| ending == "csv"))
}

/// The robot of a folder that has one.
pub fn robot_of(folder: &Path) -> Result<Option<RobotFile>, CampaignError> {
    let file = folder.join("robot.toml");
    if file.exists() { RobotFile::read(&file).map(Some) } else { Ok(None) }
}

/// Two times within this are written in one row \[s\]: a run file has microseconds.
const SAME_S: f64 = 2e-6;

/// The rows of a run: those of the wheels, and poses between them in rows of their own.
pub fn rows(recording: &Recording, supply_v: &[(f64, f64)], rad_per_count: f64) -> Vec<Row> {
    let counts = |phi_rad: f64| {
        let counts = phi_rad / rad_per_count;
        // Whole counts stay whole.
        let whole = counts.round();
        Some(if (counts - whole).abs() < 1e-6 * whole.abs().max(1.0) && whole.abs() > 0.5 {
            whole
        } else {
            counts
        })
    };
    let mut rows: Vec<Row> = Vec::new();
    for sample in &recording.wheels {
        let mut row = Row { t_s: sample.t_s, ..Row::default() };
        row.set(Column::LeftCounts, counts(sample.phi_rad.left));
        row.set(Column::RightCounts, counts(sample.phi_rad.right));
        rows.push(row);
    }
    for pose in &recording.measured_poses {
        let mut row = Row { t_s: pose.t_s, ..Row::default() };
        row.set(Column::X, pose.position_m.map(|[x_m, _]| x_m));
        row.set(Column::Y, pose.position_m.map(|[_, y_m]| y_m));
        row.set(Column::Heading, pose.heading_rad);
        rows.push(row);
    }
    let gyro = recording.gyro.iter().map(|s| (s.t_s, Column::GyroZ, s.rate_rad_s));
    let supply = supply_v.iter().map(|(t_s, volts)| (*t_s, Column::BusV, *volts));
    for (t_s, column, value) in gyro.chain(supply) {
        // A wild value is no measurement.
        if column.range().contains(value) {
            let mut row = Row { t_s, ..Row::default() };
            row.set(column, Some(value));
            rows.push(row);
        }
    }
    rows.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    rows.dedup_by(|later, first| {
        if later.t_s - first.t_s > SAME_S {
            return false;
        }
        for column in Column::ALL.into_iter().filter(|column| *column != Column::Time) {
            first.set(column, first.get(column).or(later.get(column)));
        }
        true
    });
    rows
}
