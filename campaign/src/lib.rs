//! Campaign folders: recorded runs of one robot, in files that people and other loggers can write.
//!
//! ```text
//! my-robot/
//!   robot.toml            what is nominal, and facts about single runs      -> [`RobotFile`]
//!   runs/01_straight.csv  one row per sample, SI units in the column names  -> [`Row`]
//!   plan.toml             the runs to drive, if it was planned              -> [`plan`]
//!   model.toml            the effects that its owner has accepted           -> [`model`]
//!   motors.toml           the same of its motors                            -> [`motor_model`]
//! ```
//!
//! ```no_run
//! # fn main() -> Result<(), campaign::CampaignError> {
//! let folder = std::path::Path::new("my-robot");
//! let (campaign, recordings) = campaign::Campaign::read_both(folder)?;
//! let model = recordings.into_model(&campaign, folder)?;
//! println!("{} runs of {}", model.runs.len(), campaign.robot.name);
//! # Ok(())
//! # }
//! ```
//!
//! Every error names its place, the problem and what to try ([`CampaignError`]); what is only
//! suspicious is a [`Warning`]. `robot-model` finds what is wrong with the data; this crate puts it
//! into words. It does not print, ask, or talk to a robot.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`read`], [`mod@write`] | whole folders |
//! | [`announced_runs`] | many runs that are written at once |
//! | [`robot_toml`], [`row`], [`table`] | one file, one row, any CSV file |
//! | [`range`] | which numbers can be meant |
//! | [`recorded`] | a campaign as its files have it |
//! | [`to_recording`] | a campaign as `robot-model` takes it |
//! | [`to_experiments`] | the same for the motors: voltages and counts |
//! | `duplicate_runs` | runs that are copies of others, which count once |
//! | `checks` | data that are wrong, in words |
//! | [`model`] | `model.toml` |
//! | [`motor_model`] | `motors.toml` |
//! | `equation_words` | what is wrong with an equation of the user's own, in words |
//! | [`plan`] | `plan.toml`, and which runs are worth driving |
//! | [`track`], [`live_file`] | track files, complete or still being written |
//! | `run_facts` | facts of runs, which appear together with their runs |
//! | [`lock`] | one writer at a time |
//! | [`simulated`] | which simulated robot a campaign was recorded on |
//! | [`words`] | why `robot-model` cannot use a recording, in words |
//! | [`error`], [`os_error`] | errors and warnings; the operating system's, for a user |
//! | [`bounded_read`], [`bounded_text`] | what is read: files only, of a size in proportion; and how much of it is quoted |
//! | [`mod@file`], [`disk`] | files that appear whole or not at all; what keeps their bytes |
//! | [`new_folders`] | folders made for files to come, and folders that appear whole |

pub mod announced_runs;
pub mod bounded_read;
pub mod bounded_text;
mod checks;
pub mod disk;
mod duplicate_runs;
mod equation_words;
pub mod error;
pub mod file;
pub mod live_file;
pub mod lock;
pub mod model;
pub mod motor_model;
pub mod new_folders;
pub mod os_error;
pub mod plan;
pub mod range;
pub mod read;
pub mod recorded;
pub mod robot_toml;
pub mod row;
mod run_facts;
pub mod simulated;
pub mod table;
pub mod to_experiments;
pub mod to_recording;
mod toml_text;
pub mod track;
pub mod words;
pub mod write;

#[cfg(test)]
mod tests;

pub use error::{CampaignError, CopiedRun, Place, Warning, how_far};
pub use read::{parse_run, read_run};
pub use recorded::{Campaign, Run};
pub use robot_toml::{RobotFile, RunFacts, mean_radius_m};
pub use row::{Column, Row};
pub use simulated::Simulated;
pub use to_experiments::{Experiments, MotorRun};
pub use to_recording::Recordings;
pub use write::{CampaignWriter, RunWriter};
