//! The page on which a robot is watched while it moves, and driven for as long as somebody holds a button.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `robot.rs` | [`Robot`]: what the robot said last, and what the page wishes |
//! | `robot_session.rs` | the session with the robot, in a thread of its own |
//! | `procedure.rs` | what the page guides through: commands of the terminal, whose questions the page asks |
//! | `asked.rs` | which command, with which options |
//! | `campaign_so_far.rs` | what a campaign says while it is recorded |
//! | `driven.rs` | what was driven since the last motion began |
//! | `prediction.rs` | where a model says that the robot is, and how sure that is |
//! | `server.rs` | the page, its telemetry, wishes and procedures over HTTP |
//! | `assets/` | the page itself |
//!
//! The page keeps a motion alive, not this program: each lease is renewed when a message of the page arrives, and by nothing
//! else. A tab that is closed or frozen, a network that is cut and a server that is killed stop the robot alike, a
//! [lease](host_link::session::LEASE) after the last message.

mod asked;
mod campaign_so_far;
mod driven;
mod prediction;
mod procedure;
mod robot;
mod robot_session;
mod server;

pub use prediction::{Predictor, predict_for};
pub use procedure::{Procedures, RunCommand, ServeModel};
pub use robot::Robot;
pub use robot_session::keep_session;
pub use server::{RobotPage, serve};
