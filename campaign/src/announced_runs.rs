//! Many runs that are written at once: their facts are there before the first of them appears, and `robot.toml` is written twice
//! in all.

use std::path::PathBuf;

use crate::error::{CampaignError, Place};
use crate::file::write_next_on;
use crate::new_folders::NewFolders;
use crate::robot_toml::RunFacts;
use crate::run_facts;
use crate::write::{CampaignWriter, RunWriter, check_name, next_number, refuse_link, unwritten};

/// Runs whose facts are in `robot.toml`, and whose files are written one after the other.
#[derive(Debug)]
pub struct AnnouncedRuns<'a> {
    writer: &'a CampaignWriter,
    names: Vec<String>,
    written: Vec<PathBuf>,
    _made: NewFolders,
}

impl<'a> AnnouncedRuns<'a> {
    /// Adds the facts of runs to come. Their names are what [`CampaignWriter::start_run`] takes, and get their numbers here.
    pub fn new(
        writer: &'a CampaignWriter,
        mut facts: Vec<RunFacts>,
    ) -> Result<Self, CampaignError> {
        let runs = writer.folder.join("runs");
        for run in &facts {
            check_name(&runs, &run.name)?;
        }
        let made = match facts.first() {
            Some(first) => writer.check_new_run(&first.name)?,
            None => NewFolders::default(),
        };
        for (run, number) in facts.iter_mut().zip(next_number(&writer.folder)?..) {
            run.name = format!("{number:02}_{}", run.name);
        }
        let known: Vec<_> = facts.iter().filter(|facts| facts.has_any()).cloned().collect();
        if !known.is_empty() {
            run_facts::announce(&*writer.disk, &writer.folder.join("robot.toml"), &known)?;
        }
        let names = facts.into_iter().map(|facts| facts.name).collect();
        Ok(Self { writer, names, written: Vec::new(), _made: made })
    }

    /// Writes the file of the next one.
    pub fn write(&mut self, run: &RunWriter) -> Result<(), CampaignError> {
        run.check_rows()?;
        let runs = self.writer.folder.join("runs");
        refuse_link(&runs)?;
        let path = runs.join(format!("{}.csv", self.names[self.written.len()]));
        let written = write_next_on(&*self.writer.disk, &path, run.text.as_bytes());
        if !written.map_err(|error| unwritten(&path, error))? {
            let problem = "somebody else has written it meanwhile";
            let hint = "give the same command again";
            return Err(CampaignError::new(Place::whole(&path), problem, hint));
        }
        self.written.push(path);
        Ok(())
    }

    /// All are written: their files, in this order.
    pub fn finish(self) -> Result<Vec<PathBuf>, CampaignError> {
        run_facts::resolve_pending(&*self.writer.disk, &self.writer.folder)?;
        Ok(self.written)
    }
}
