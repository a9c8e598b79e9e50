//! Logs of other programs become campaign folders, and what a campaign says goes back to other programs.
//!
//! ```text
//! bags, tables, trajectories --source--> wheels and poses --understand--> runs on one clock --write--> a campaign
//! a campaign --export--> parameters of a controller, trajectories, bags
//! ```
//!
//! ```no_run
//! # fn main() -> Result<(), campaign::CampaignError> {
//! use import::source::{Choice, Sources};
//! use import::understand::{Hints, understand};
//!
//! let sources = Sources::open(&["drive.mcap".into()], &[])?;
//! let chosen = sources.choose(&Choice::default())?;
//! let hints = Hints { wheel_radius_m: Some(0.033), track_width_m: Some(0.16), ..Hints::default() };
//! let understood = understand(chosen.wheels, &chosen.poses, &hints, chosen.same_clock)?;
//! import::write::write(&understood, std::path::Path::new("my-robot"), false)?;
//! # Ok(())
//! # }
//! ```
//!
//! What is certain is done and said ([`log::Note`]); what is not is one error, with its file, the problem, and what to do
//! (`campaign::CampaignError`). Nothing here prints or asks.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`source`] | which files there are, and what of them is wheels and poses |
//! | [`bag`], [`mcap`], [`sqlite`], [`received`] | ROS 2 bags: topics; the two formats of files; what both give |
//! | [`message`], [`cdr`], `joints` | messages, their encoding, and wheels of joint states |
//! | [`odometry`], [`geometry`], [`controller_file`] | wheels of odometry; the numbers that it used, and where they are written |
//! | [`text`], [`wpilog`] | tables and trajectories; data logs of WPILib |
//! | [`log`] | what every source becomes |
//! | [`understand`] | the whole of the way from two logs to runs |
//! | [`turns`], [`plane`], `gyro` | wheels without wraps; poses on the floor; which axis of a gyro is up |
//! | [`alignment`], [`cut`], [`mend`], `outliers` | one clock; runs; axes and signs; poses that are elsewhere |
//! | [`mod@write`] | a campaign folder |
//! | [`export`] | what goes back |

pub mod alignment;
mod angle;
pub mod bag;
pub mod cdr;
pub mod controller_file;
pub mod cut;
pub mod export;
pub mod geometry;
mod gyro;
mod joints;
pub mod log;
pub mod mcap;
pub mod mend;
pub mod message;
pub mod odometry;
mod outliers;
pub mod plane;
pub mod received;
pub mod source;
pub mod sqlite;
pub mod text;
pub mod turns;
pub mod understand;
pub mod wpilog;
pub mod write;
