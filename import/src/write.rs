//! Writes what was understood as a campaign folder.

use std::path::{Component, Path, PathBuf};

use campaign::announced_runs::AnnouncedRuns;
use campaign::new_folders::NewFolder;
use campaign::{CampaignError, CampaignWriter, Column, RobotFile, Row, RunFacts};

use robot_model::recording::Recording;

use crate::log::error;
use crate::understand::{RunUnderstood, Understood};

/// What [`write()`] wrote.
#[derive(Clone, Debug)]
pub struct Written {
    /// The names of all runs of the log.
    pub names: Vec<String>,
    /// How many of them were in the folder already, byte by byte, and were not written again.
    pub were_there: usize,
}

/// Writes a campaign.
///
/// A new folder appears whole or not at all. In one that exists, each run does; runs of this log that are there already stay
/// as they are, so that an import that was interrupted is completed by the same one. Other runs must not be there, unless
/// `is_adding`.
pub fn write(
    understood: &Understood,
    folder: &Path,
    is_adding: bool,
) -> Result<Written, CampaignError> {
    write_with(understood, folder, is_adding, |_, _| Ok(()))
}

/// The same; `complete` writes what belongs to the campaign besides, into this folder, before a new one appears.
pub fn write_with(
    understood: &Understood,
    folder: &Path,
    is_adding: bool,
    complete: impl Fn(&Path, &Written) -> Result<(), CampaignError>,
) -> Result<Written, CampaignError> {
    // Of `robot/.` the last name is that of the folder.
    let folder: &Path = &folder.components().collect::<PathBuf>();
    if folder.exists() && !folder.is_dir() {
        return Err(error(folder, "this is a file, and no folder", "choose another name with -o"));
    }
    let cannot = |cause| CampaignError::io(folder, "make this folder", cause);
    if !folder.exists() {
        let new = NewFolder::make(folder).map_err(cannot)?;
        let of_its_place = |mut error: CampaignError| {
            if let Ok(within) = error.place.file.strip_prefix(new.path()) {
                error.place.file = folder.join(within);
            }
            error
        };
        let written = into(understood, new.path(), is_adding, &complete).map_err(of_its_place)?;
        match new.persist() {
            Ok(true) => return Ok(written),
            Ok(false) => {}
            Err(cause) if folder.exists() => {
                let problem =
                    format!("it is written, and could not be synced to the disk ({cause})");
                return Err(error(folder, problem, "check the disk: a power failure may undo it"));
            }
            Err(cause) => return Err(cannot(cause)),
        }
        // Somebody else has made it meanwhile.
    }
    into(understood, folder, is_adding, &complete)
}

fn into(
    understood: &Understood,
    folder: &Path,
    is_adding: bool,
    complete: &impl Fn(&Path, &Written) -> Result<(), CampaignError>,
) -> Result<Written, CampaignError> {
    let writer = CampaignWriter::open(folder, &understood.robot)?;
    let rad_per_count = understood.robot.to_model().rad_per_count;
    let draft = |run: &RunUnderstood| {
        let mut columns = vec![Column::X, Column::Y, Column::Heading];
        columns.extend((!run.recording.gyro.is_empty()).then_some(Column::GyroZ));
        columns.extend((!run.supply_v.is_empty()).then_some(Column::BusV));
        let mut draft = writer.draft_run(&run.name, &columns);
        for row in rows(&run.recording, &run.supply_v, rad_per_count) {
            draft.push(&row)?;
        }
        Ok(draft)
    };
    // Of a log that fills the memory no second copy is made: what is compared is made again to be written.
    let mut others = writer.runs()?;
    let mut there = vec![None; understood.runs.len()];
    if !others.is_empty() {
        for (run, there) in understood.runs.iter().zip(&mut there) {
            let draft = draft(run)?;
            let index = others.iter().position(|other| draft.is_written_in(other));
            *there = index.map(|index| others.remove(index));
        }
    }
    if !is_adding && !others.is_empty() {
        let hint = "choose another folder with -o, or add these runs to its own with --add";
        return Err(error(folder, "this campaign has runs already", hint));
    }
    let were_there = there.iter().flatten().count();
    let missing = || understood.runs.iter().zip(&there).filter(|(_, there)| there.is_none());
    let facts = missing().map(|(run, _)| RunFacts {
        name: run.name.clone(),
        started_s: Some(run.started_s),
        ..RunFacts::default()
    });
    let mut announced = AnnouncedRuns::new(&writer, facts.collect())?;
    for (run, _) in missing() {
        announced.write(&draft(run)?)?;
    }
    let mut new = announced.finish()?.into_iter();
    let name = |path: PathBuf| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let names = there.into_iter().filter_map(|there| there.or_else(|| new.next())).map(name);
    let written = Written { names: names.collect(), were_there };
    complete(folder, &written)?;
    Ok(written)
}

/// What a robot is called whose campaign has this folder: the innermost name that is not only a date.
pub fn name_of(folder: &Path) -> Option<String> {
    let mut names = folder.components().rev().filter_map(|part| match part {
        Component::Normal(name) => Some(name.to_string_lossy().into_owned()),
        _ => None,
    });
    names.find(|name| name.chars().any(char::is_alphabetic))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_is_named_after_its_folder_or_the_one_around_a_date() {
        for (folder, name) in [
            ("my-robot", Some("my-robot")),
            ("fleet/robot3/2025-03-01", Some("robot3")),
            ("./my-robot/.", Some("my-robot")),
            ("/", None),
            ("..", None),
            ("2025-03-01", None),
        ] {
            assert_eq!(name_of(Path::new(folder)).as_deref(), name, "{folder}");
        }
    }
}
