//! The tasks: short async loops around the steps of the other modules.
//!
//! Each `run` is generic and never ends. A board wraps `run` in an `#[embassy_executor::task]` with
//! concrete types; the simulator spawns `run` directly.

pub mod capture;
pub mod heartbeat;
pub mod link;
pub mod pid;
pub mod profile;
pub mod safety_inputs;
pub mod supervisor;
pub mod telemetry;
