//! Campaign folders: recorded runs of one robot, in files that people and other loggers can write.
//!
//! ```text
//! my-robot/
//!   robot.toml            what is nominal, and facts about single runs      -> [`RobotFile`]
//!   runs/01_straight.csv  one row per sample, SI units in the column names  -> [`Row`]
//! ```

mod believe;
mod convention;
mod error;
mod gate;
mod read;
pub(crate) mod robot_toml;
mod row;
pub(crate) mod table;
#[cfg(test)]
mod tests;
mod write;

pub use convention::{Convention, Meant};
pub(crate) use error::how_far;
pub use error::{CampaignError, Place, Warning};
pub use read::{Campaign, Run, read_run};
pub use robot_toml::{RobotFile, RunFacts, Simulated};
pub use row::{Column, Row};
pub use write::{CampaignWriter, RunWriter};
