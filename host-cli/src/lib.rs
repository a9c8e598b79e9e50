//! The `beeline` command: talks to a robot, records, calibrates, explains.
//!
//! The link to a robot is `host-link`, campaign folders are `campaign`, and models are fitted by
//! `robot-model`.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`port`] | where a robot is reached |
//! | [`limits`] | which motions are refused before they are commanded |
//! | [`advice`] | what to try when a robot or a plan refuses |
//! | [`apply`] | what the firmware can compensate |
//! | [`calibrate`] | the paper's experiment as a guided procedure |
//! | [`tune`] | identifies the motors and sets the gains |
//! | [`undo`] | what `--undo` restores: configurations from before the last change |
//! | [`wheel_angles`] | telemetry counts as wheel angles |
//! | [`pose_source`] | what measures where the robot is |
//! | [`campaign_recorder`] | drives and records whole campaigns |
//! | [`mod@compare`], [`explain`], [`report`] | what a campaign says, in tables and on a page |
//! | [`fit_cache`] | what was found before, kept so that no campaign is fitted twice |
//! | [`fleet`] | what many campaigns say |
//! | [`calibration_page`] | the page and the drawing of a calibration |
//! | [`import_page`] | what an import understood, on a page |
//! | [`model_page`] | the page on which effects are switched on and off |
//! | [`robot_page`] | the page on which a robot is watched and driven |
//! | [`page_server`] | serves a page on this machine |
//! | [`config_text`] | the robot's configuration as text |
//! | [`mod@hex`] | bytes as hexadecimal text |
//! | [`motors`] | what the motors lack, in words |
//! | [`words`], [`json`] | what `robot-model` finds, in sentences and as JSON |
//! | [`watch`] | a robot on the whole screen of a terminal, or as lines |
//! | [`quantity`] | numbers with units, read and written |
//! | [`cli`], [`command`] | the command line; one file per command |
//! | [`error`], [`interrupt`] | errors for a person, Ctrl-C |
//! | [`ui`], [`table`] | lines, progress, questions and tables on a terminal |
//! | [`dialogue`], [`question`] | the same where a page runs a command |

pub mod advice;
pub mod apply;
pub mod calibrate;
pub mod calibration_page;
pub mod campaign_recorder;
pub mod cli;
pub mod command;
pub mod compare;
pub mod config_text;
pub mod dialogue;
pub mod error;
pub mod escape;
pub mod explain;
pub mod fit_cache;
pub mod fleet;
pub mod hex;
pub mod import_page;
pub mod interrupt;
pub mod limits;
pub mod model_page;
pub mod motor_page;
pub mod motors;
pub mod page_server;
pub mod port;
pub mod pose_source;
pub mod question;
pub mod report;
pub mod robot_page;
pub mod table;
pub mod tune;
pub mod ui;
pub mod undo;
pub mod watch;
pub mod wheel_angles;
pub mod wiring;

/// What is found, in sentences and as JSON, and numbers with units: `findings` is for other programs as well.
pub use findings::{json, quantity, words};
