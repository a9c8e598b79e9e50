//! What a campaign says, for other programs: parameters of a ROS 2 controller, trajectories, tables, bags.
//!
//! | file | what it is |
//! | --- | --- |
//! | `controller.rs` | [`Controller`]: the numbers that `diff_drive_controller` can have, and what they cannot say |
//! | `trajectory.rs` | [`Trajectory`]: wheels, measured poses and odometry of each run; as TUM, CSV and MCAP |
//! | `definitions.rs` | the definitions of the messages that bags have |

mod controller;
mod definitions;
mod trajectory;

pub use controller::{Controller, Cost};
pub use trajectory::{Trajectory, bag, table};
