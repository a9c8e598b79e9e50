//! The tasks: short async loops round the steps of the other modules.
//!
//! Each `run` is generic and never ends; a board's binary wraps it in an
//! `#[embassy_executor::task]` of concrete types, the simulator spawns it as it is.

pub mod capture;
pub mod link;
pub mod pid;
pub mod profile;
pub mod safety_inputs;
pub mod supervisor;
pub mod telemetry;
