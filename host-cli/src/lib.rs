//! The `beeline` command: talks to a robot, records, calibrates, explains.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`port`] | where a robot is reached |
//! | [`link`] | its bytes, and the time they go by |
//! | [`session`] | handshake, requests with retries, telemetry |
//! | [`motion`] | drives a motion to its end, safely |
//! | [`limits`] | what a motion may ask of a robot |
//! | [`apply`] | what the firmware can compensate |
//! | [`calibrate`] | the paper's experiment as a guided procedure |
//! | [`undo`] | what was there before the last change |
//! | [`campaign`] | recorded runs on disk |
//! | [`survey`] | plans and records whole campaigns |
//! | [`model`] | `model.toml`: the effects that a user believes in |
//! | [`mod@compare`], [`explain`], [`report`] | what a campaign says, in tables and on a page |
//! | [`track`] | measured tracks from elsewhere |
//! | [`picture`] | what a person sees at the end |
//! | [`mod@file`] | files that appear whole or not at all |
//! | [`mod@hex`] | bytes as people compare them |
//! | [`quantity`] | numbers with units, read and written |
//! | [`cli`], [`command`] | the command line, one file a command |

pub mod apply;
pub mod calibrate;
pub mod campaign;
pub mod cli;
pub mod command;
pub mod compare;
pub mod error;
pub mod explain;
pub mod file;
pub mod hex;
pub mod interrupt;
pub mod limits;
pub mod link;
pub mod model;
pub mod motion;
pub mod picture;
pub mod port;
pub mod quantity;
pub mod report;
pub mod serve;
pub mod session;
pub mod stream;
pub mod survey;
pub mod table;
pub mod track;
pub mod ui;
pub mod undo;
