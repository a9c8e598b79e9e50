//! Writes campaign folders: every file appears whole or not at all, and no run is ever overwritten.
//!
//! How a file appears whole is left to [`crate::file`], how a run and its facts appear together to `run_facts`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::read::run_files;
use super::{CampaignError, Column, Place, RobotFile, Row, RunFacts, Warning};
use crate::bounded_read;
use crate::disk::{Disk, SystemDisk};
use crate::file::{WriteError, check_own, check_writable, write_new_on, write_own_on};
use crate::lock::FolderLock;
use crate::new_folders::NewFolders;
use crate::range;
use crate::run_facts;

/// The longest name of a run, which becomes part of a file's name.
const NAME_MAX: usize = 100;

/// A campaign folder to add runs to. While it exists, no other process can.
#[derive(Debug)]
pub struct CampaignWriter {
    pub(crate) folder: PathBuf,
    robot: RobotFile,
    pub(crate) disk: Arc<dyn Disk>,
    lock: Arc<FolderLock>,
}

impl CampaignWriter {
    /// Opens the folder for `robot`, and creates it if it does not exist.
    ///
    /// An existing `robot.toml` stays as it is; that of another robot is refused.
    pub fn open(folder: &Path, robot: &RobotFile) -> Result<Self, CampaignError> {
        Self::open_on(Arc::new(SystemDisk), folder, robot)
    }

    /// The same, on this disk.
    pub fn open_on(
        disk: Arc<dyn Disk>,
        folder: &Path,
        robot: &RobotFile,
    ) -> Result<Self, CampaignError> {
        let toml = folder.join("robot.toml");
        let mut new = String::new();
        // Before the lock: its file goes before the folder does, if that stays empty.
        let mut made = NewFolders::default();
        if !toml.exists() {
            refuse_to_lose_facts(folder, &toml)?;
            new = toml::to_string(robot).map_err(|error| {
                let hint = "check the robot's name and numbers";
                CampaignError::new(Place::whole(&toml), format!("cannot write it: {error}"), hint)
            })?;
            robot.check(&toml, &new)?;
            made = NewFolders::make(folder)
                .map_err(|error| CampaignError::io(folder, "make this folder", error))?;
        }
        let lock = FolderLock::take(folder)?;
        // Asked again: before the lock was ours, another process may have made it, and recorded.
        let robot = if toml.exists() {
            existing(&*disk, folder, robot)?
        } else {
            write_own_on(&*disk, &toml, new.as_bytes()).map_err(|error| unwritten(&toml, error))?;
            robot.clone()
        };
        drop(made);
        Ok(Self { folder: folder.into(), robot, disk, lock: Arc::new(lock) })
    }

    /// The nominal robot of this folder.
    pub fn robot(&self) -> &RobotFile {
        &self.robot
    }

    /// Adds to `robot.toml` how well poses are measured, one sigma \[m, rad\], where it is missing.
    ///
    /// A value that exists stays; one that is far from these is a warning.
    pub fn keep_sigmas(
        &self,
        position_m: f64,
        heading_rad: f64,
    ) -> Result<Vec<Warning>, CampaignError> {
        /// A noise is seldom known more exactly.
        const FAR: f64 = 1.5;
        let toml = self.folder.join("robot.toml");
        let robot = RobotFile::read(&toml)?;
        let mut warnings = Vec::new();
        let mut lines = String::new();
        for (name, there, here) in [
            ("position_sigma_m", robot.position_sigma_m, position_m),
            ("heading_sigma_rad", robot.heading_sigma_rad, heading_rad),
        ] {
            match there {
                None => lines += &format!("{name} = {here}\n"),
                Some(there) if there > FAR * here || here > FAR * there => {
                    let place = Place::whole(&toml);
                    warnings.push(Warning::OtherNoise { place, name, there, here });
                }
                Some(_) => {}
            }
        }
        if !lines.is_empty() {
            let text = bounded_read::read_keys(&toml)
                .map_err(|error| CampaignError::io(&toml, "read it", error))?;
            let text = before_sections(&text, &lines);
            RobotFile::parse(&toml, &text)?;
            write_own_on(&*self.disk, &toml, text.as_bytes())
                .map_err(|error| unwritten(&toml, error))?;
        }
        Ok(warnings)
    }

    /// Adds the facts of a run of the folder to `robot.toml`; false if it has an entry there already.
    pub fn restore_facts(&self, run: &str, facts: &RunFacts) -> Result<bool, CampaignError> {
        let toml = self.folder.join("robot.toml");
        if RobotFile::read(&toml)?.runs.iter().any(|entry| entry.name == run) {
            return Ok(false);
        }
        run_facts::add(&*self.disk, &toml, &[RunFacts { name: run.into(), ..facts.clone() }])?;
        Ok(true)
    }

    /// The files of the runs that are there, in order of their names.
    pub fn runs(&self) -> Result<Vec<PathBuf>, CampaignError> {
        Ok(run_files(&self.folder)?.files.into_iter().map(|(_, file)| file).collect())
    }

    /// Starts a run. Its file is named by the next free number and `name`: `07_name`.
    ///
    /// `columns` need not name the required ones; the order is that of [`Column::ALL`].
    pub fn start_run(&self, name: &str, columns: &[Column]) -> Result<RunWriter, CampaignError> {
        let made = self.check_new_run(name)?;
        Ok(self.run_writer(name, columns, made))
    }

    /// Checks, before anything drives, that a run of this name can be kept; its folder, made if it was missing.
    pub(crate) fn check_new_run(&self, name: &str) -> Result<NewFolders, CampaignError> {
        let runs = self.folder.join("runs");
        check_name(&runs, name)?;
        let made = NewFolders::make(&runs)
            .map_err(|error| CampaignError::io(&runs, "make this folder", error))?;
        refuse_link(&runs)?;
        check_writable(&runs.join(name))
            .map_err(|error| CampaignError::io(&runs, "write into this folder", error.into()))?;
        let toml = self.folder.join("robot.toml");
        check_own(&toml).map_err(|error| unwritten(&toml, error))?;
        Ok(made)
    }

    fn run_writer(&self, name: &str, columns: &[Column], made: NewFolders) -> RunWriter {
        let columns: Vec<_> = Column::ALL
            .into_iter()
            .filter(|column| columns.contains(column) || Column::REQUIRED.contains(column))
            .collect();
        let header: Vec<_> = columns.iter().map(|column| column.name()).collect();
        let text = header.join(",") + "\n";
        RunWriter {
            folder: self.folder.clone(),
            disk: self.disk.clone(),
            _lock: self.lock.clone(),
            _made: made,
            name: name.into(),
            columns,
            text,
            rows: 0,
            last_s: f64::NEG_INFINITY,
        }
    }

    /// A run in memory, to be compared with files, or written as one of [`AnnouncedRuns`](crate::announced_runs::AnnouncedRuns).
    pub fn draft_run(&self, name: &str, columns: &[Column]) -> RunWriter {
        self.run_writer(name, columns, NewFolders::default())
    }
}

/// A run being written: in memory until [`RunWriter::finish`], so that a program that ends before
/// it leaves nothing behind.
#[derive(Debug)]
pub struct RunWriter {
    folder: PathBuf,
    disk: Arc<dyn Disk>,
    _lock: Arc<FolderLock>,
    _made: NewFolders,
    name: String,
    columns: Vec<Column>,
    pub(crate) text: String,
    rows: u64,
    last_s: f64,
}

impl RunWriter {
    /// Adds a sample. Its time must be later than that of the sample before, and its numbers
    /// in their ranges.
    pub fn push(&mut self, row: &Row) -> Result<(), CampaignError> {
        let fail = |problem: String, column: usize| {
            let line = self.rows + 2;
            let place = Place { file: self.path(), line, column: column as u64 + 1 };
            CampaignError::new(place, problem, "nothing of this run was kept")
        };
        let mut cells = Vec::with_capacity(self.columns.len());
        for (index, column) in self.columns.iter().enumerate() {
            let value = row.get(*column);
            if let Some(value) = value.filter(|value| !column.range().contains(*value)) {
                let (name, value) = (column.name(), range::short(value));
                let problem = format!("{name} is {value}, and must be {}", column.range());
                return Err(fail(problem, index));
            }
            cells.push(value.map_or_else(String::new, |value| column.format(value)));
        }
        // Compared as they are written: two times within a microsecond are equal in the file.
        let t_s = cells[0].parse().unwrap_or(row.t_s);
        if t_s <= self.last_s {
            return Err(fail(format!("the time goes from {} s to {t_s} s", self.last_s), 0));
        }
        self.last_s = t_s;
        self.rows += 1;
        self.text.push_str(&cells.join(","));
        self.text.push('\n');
        Ok(())
    }

    /// Whether this file holds the same run, byte by byte.
    pub fn is_written_in(&self, file: &Path) -> bool {
        let is_as_long =
            std::fs::metadata(file).is_ok_and(|there| there.len() == self.text.len() as u64);
        is_as_long && std::fs::read(file).is_ok_and(|bytes| bytes == self.text.as_bytes())
    }

    /// Writes the file, and the facts, with the name filled in, into `robot.toml`: both appear together.
    ///
    /// Without this call nothing of the run is kept.
    pub fn finish(self, facts: RunFacts) -> Result<PathBuf, CampaignError> {
        self.check_rows()?;
        let runs = self.folder.join("runs");
        refuse_link(&runs)?;
        let (disk, folder) = (&*self.disk, &self.folder);
        let mut number = next_number(&self.folder)?;
        loop {
            let name = format!("{number:02}_{}", self.name);
            let path = runs.join(format!("{name}.csv"));
            let facts = RunFacts { name, ..facts.clone() };
            let has_facts = facts.has_any();
            if has_facts {
                run_facts::announce(disk, &folder.join("robot.toml"), &[facts])?;
            }
            let written = write_new_on(disk, &path, self.text.as_bytes());
            // The run stands or falls with its file. An entry that stays pending is settled by the next writer.
            let settled = if has_facts { run_facts::resolve_pending(disk, folder) } else { Ok(()) };
            match written.map_err(|error| unwritten(&path, error))? {
                true => return Ok(path),
                // A program that does not know the lock has recorded into this folder meanwhile.
                false => settled?,
            }
            number += 1;
        }
    }

    pub(crate) fn check_rows(&self) -> Result<(), CampaignError> {
        if self.rows >= 2 {
            return Ok(());
        }
        let problem = format!("a run needs at least two samples, this one has {}", self.rows);
        let hint = "record for longer; nothing was written";
        Err(CampaignError::new(Place::whole(&self.folder.join("runs")), problem, hint))
    }

    fn path(&self) -> PathBuf {
        self.folder.join("runs").join(format!("{}.csv", self.name))
    }
}

/// What may be the name of a run, in this folder.
pub(crate) fn check_name(runs: &Path, name: &str) -> Result<(), CampaignError> {
    let sound = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
    if name.is_empty() || !name.chars().all(sound) {
        let problem = format!("`{name}` cannot be the name of a run");
        let hint = "use letters, digits, - and _, for example straight_back";
        return Err(CampaignError::new(Place::whole(runs), problem, hint));
    }
    if name.len() > NAME_MAX {
        let problem = format!("the name of the run has {} characters", name.len());
        let hint = format!("use at most {NAME_MAX}");
        return Err(CampaignError::new(Place::whole(runs), problem, hint));
    }
    Ok(())
}

/// The number of the next run in a folder: one above the highest with which a run begins, or the facts of one that was removed.
pub fn next_number(folder: &Path) -> Result<u64, CampaignError> {
    let leading = |name: &str| {
        let digits: String = name.chars().take_while(char::is_ascii_digit).collect();
        digits.parse::<u32>().map_or(0, u64::from)
    };
    let files = run_files(folder)?.files;
    let toml = folder.join("robot.toml");
    let facts = if toml.exists() { RobotFile::read(&toml)?.runs } else { Vec::new() };
    let names = files.iter().map(|(name, _)| name).chain(facts.iter().map(|facts| &facts.name));
    Ok(names.map(|name| leading(name)).max().unwrap_or(0) + 1)
}

/// A TOML file with these lines added before its first section; the rest stays as people wrote it.
fn before_sections(text: &str, lines: &str) -> String {
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        if line.trim_start().starts_with('[') {
            break;
        }
        at += line.len();
    }
    // After the last line that is not blank.
    let head = text[..at].trim_end();
    format!("{head}\n{lines}{}", &text[head.len()..].strip_prefix('\n').unwrap_or_default())
}

/// The robot of a folder that has one, with its facts settled; refused if it is another robot.
fn existing(disk: &dyn Disk, folder: &Path, robot: &RobotFile) -> Result<RobotFile, CampaignError> {
    let toml = folder.join("robot.toml");
    let there = RobotFile::read(&toml)?;
    if let Some((name, there, here)) = there.difference(robot) {
        let problem = format!("{name} = {there} is of another robot: this one has {here}");
        let hint = "choose another folder, or correct the file if it is wrong";
        return Err(CampaignError::new(Place::whole(&toml), problem, hint));
    }
    // Whether facts can be added must be known before a run is driven.
    let facts = RunFacts { started_s: Some(0.0), ..RunFacts::default() };
    run_facts::with_facts(&toml, &[facts])?;
    run_facts::resolve_pending(disk, folder)?;
    Ok(RobotFile { runs: RobotFile::read(&toml)?.runs, ..there })
}

/// A folder that has runs and no `robot.toml` has lost what that said of them. With a new one in its place nobody would notice.
fn refuse_to_lose_facts(folder: &Path, toml: &Path) -> Result<(), CampaignError> {
    let runs = run_files(folder)?.files.len();
    if runs == 0 {
        return Ok(());
    }
    let problem = format!(
        "it is missing, and with it what it said of the {runs} run{} in this folder: start, load, held out",
        if runs == 1 { "" } else { "s" }
    );
    let hint = "put it back, or write a new one; or choose another folder";
    Err(CampaignError::new(Place::whole(toml), problem, hint))
}

/// Who made the folder may have linked its runs to a folder that is no part of it.
pub(crate) fn refuse_link(runs: &Path) -> Result<(), CampaignError> {
    if !runs.is_symlink() {
        return Ok(());
    }
    let hint = "replace it by a folder, or choose another folder for the campaign";
    let problem = "cannot write into this folder (it is a link)";
    Err(CampaignError::new(Place::whole(runs), problem, hint))
}

pub(crate) fn unwritten(path: &Path, error: WriteError) -> CampaignError {
    CampaignError::io(path, "write it", error.into())
}
