//! A robot watched live: on the whole screen of a terminal, or as lines.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `condition.rs` | [`Condition`]: state, faults with what to do, who drives, how the link is |
//! | `history.rs` | [`History`]: the last seconds of telemetry, and the path |
//! | `shown.rs` | [`Shown`]: what is drawn, and in which styles |
//! | `view.rs`, `wheels.rs` | how it is drawn |
//! | `screen.rs` | [`Screen`]: takes the terminal, gives it back, and reads keys |
//! | `columns.rs` | [`Column`]: what a line shows |
//!
//! Nothing here talks to the robot: that is left to the command.

mod columns;
mod condition;
mod history;
mod screen;
mod shown;
#[cfg(test)]
mod tests;
mod view;
mod wheels;

pub use columns::{Column, USUAL};
pub use condition::{Condition, Driver};
pub use history::History;
pub use screen::{Key, Screen};
pub use shown::Shown;
pub use view::draw;
