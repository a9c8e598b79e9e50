//! What a campaign says, for other programs: parameters of controllers, trajectories, tables, bags.
//!
//! | file | what it is |
//! | --- | --- |
//! | `controller.rs` | [`Controller`]: the numbers that a program can have, and what they cannot say |
//! | `target.rs` | [`Target`]: which program, and what it can be told |
//! | `parameters.rs` | the files of the programs |
//! | `trajectory.rs` | [`Trajectory`]: wheels, measured poses and odometry of each run; as TUM and CSV |
//! | `telemetry.rs` | [`Telemetry`]: what else a robot tells of itself |
//! | `bag.rs` | [`bag`]: all of these as MCAP |
//! | `definitions.rs` | the definitions of the messages that bags have |

mod bag;
mod controller;
mod definitions;
mod parameters;
mod target;
mod telemetry;
mod trajectory;

pub use bag::bag;
pub use controller::{Controller, Cost};
pub use target::Target;
pub use telemetry::Telemetry;
pub use trajectory::{Trajectory, table};
