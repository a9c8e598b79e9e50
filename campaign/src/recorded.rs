//! A campaign as in its files. What `robot-model` needs of it is made in [`crate::to_recording`].

use crate::error::{CopiedRun, Warning};
use crate::robot_toml::{RobotFile, RunFacts};
use crate::row::Row;

/// A campaign as read.
#[derive(Clone, Debug, PartialEq)]
pub struct Campaign {
    /// The robot.
    pub robot: RobotFile,
    /// Its runs, in the order of their names, each recording once.
    pub runs: Vec<Run>,
    /// Runs that are copies of others, and count no second time.
    pub copies: Vec<CopiedRun>,
    /// What was ignored, and what is suspicious.
    pub warnings: Vec<Warning>,
}

/// One recorded run.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// File name without `.csv`.
    pub name: String,
    /// What `robot.toml` says about it.
    pub facts: RunFacts,
    /// Its samples, at least two.
    pub rows: Vec<Row>,
}

impl Campaign {
    /// The names of its runs, those of copies last, without their numbers.
    pub fn plain_names(&self) -> Vec<String> {
        let copies = self.copies.iter().map(|copy| &copy.name);
        let names = self.runs.iter().map(|run| &run.name).chain(copies);
        names.map(|name| plain(name).to_owned()).collect()
    }
}

/// A run's name without its number: `07_spin_2` is `spin_2`.
pub fn plain(name: &str) -> &str {
    name.trim_start_matches(|c: char| c.is_ascii_digit()).trim_start_matches('_')
}
