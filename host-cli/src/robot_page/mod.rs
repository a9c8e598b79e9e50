//! The page on which a robot is watched while it moves, and driven for as long as somebody holds a button.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `robot.rs` | [`Robot`]: what the robot said last, and what the page wishes |
//! | `robot_session.rs` | the session with the robot, in a thread of its own |
//! | `server.rs` | the page, its telemetry and its wishes over HTTP |
//! | `assets/` | the page itself |
//!
//! The page keeps a motion alive, not this program: each lease is renewed when a message of the page arrives, and by nothing
//! else. A tab that is closed or frozen, a network that is cut and a server that is killed stop the robot alike, a
//! [lease](host_link::session::LEASE) after the last message.

mod robot;
mod robot_session;
mod server;

pub use robot::Robot;
pub use robot_session::keep_session;
pub use server::serve;
