//! The `beeline` command: talks to a robot, records, calibrates, explains.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`port`] | where a robot is reached |
//! | [`limits`] | what a motion may ask of a robot |
//! | [`advice`] | what to try where a robot or a plan refuses |
//! | [`apply`] | what the firmware can compensate |
//! | [`calibrate`] | the paper's experiment as a guided procedure |
//! | [`undo`] | what was there before the last change |
//! | [`wheels`] | counts of telemetry as angles of the wheels |
//! | [`pose_source`] | what measures where the robot is |
//! | [`survey`] | plans and records whole campaigns |
//! | [`mod@compare`], [`explain`], [`report`] | what a campaign says, in tables and on a page |
//! | [`picture`] | what a person sees at the end |
//! | [`mod@hex`] | bytes as people compare them |
//! | [`words`], [`json`] | what `robot-model` finds, in sentences and as JSON |
//! | [`quantity`] | numbers with units, read and written |
//! | [`cli`], [`command`] | the command line, one file a command |

pub mod advice;
pub mod apply;
pub mod calibrate;
pub mod cli;
pub mod command;
pub mod compare;
pub mod error;
pub mod explain;
pub mod hex;
pub mod interrupt;
pub mod json;
pub mod limits;
pub mod picture;
pub mod port;
pub mod pose_source;
pub mod quantity;
pub mod report;
pub mod survey;
pub mod table;
pub mod ui;
pub mod undo;
pub mod wheels;
pub mod words;
