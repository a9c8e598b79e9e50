//! A simulated Beeline robot: a plant, a virtual clock and a serial line, running the firmware's own tasks.
//!
//! [`SimTarget`] puts everything together: the tasks of `firmware` on an embassy executor, the
//! hardware interface on a [`plant`] of forces and torques, a serial line, and [`instruments`] that
//! measure the robot as a testbed would. A [`scenario`] describes the robot. One seed draws everything
//! that is random; the same seed gives the same bytes.

mod chassis;
mod clock;
mod executor;
mod flash;
mod guard;
mod hardware;
pub mod instruments;
mod nor;
mod pin;
pub mod plant;
mod robot_task;
pub mod scenario;
mod target;
mod testbed;
mod uid;
mod wire;
mod world;

pub use chassis::Chassis;
pub use clock::now_us;
pub use nor::Nor;
pub use robot_task::RobotTask;
pub use scenario::Scenario;
pub use target::{Options, SimTarget, sleep_until_us};
pub use testbed::Testbed;
pub use wire::{HostWire, WireParameters};
