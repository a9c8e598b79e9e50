//! A Beeline robot's firmware: the control steps, and the Embassy tasks around them.
//!
//! Start reading at [`shared`], which draws what each task passes on to which. The steps themselves
//! ([`encoder`], [`odometry`], [`profile`], [`pid`], [`probe`], [`protection`]) know nothing of tasks,
//! clocks or hardware: state and inputs in, outputs out, in fixed point. All but the probe are in the
//! package `control`, which is compiled for speed; the rest is compiled for size.
//!
//! | module | contents |
//! | --- | --- |
//! | [`task`] | the loops: encoder capture, profile, PID, link, telemetry, supervisor, safety inputs |
//! | [`hal`] | the hardware interface: what a board, or the simulator, implements |
//! | `board` | that interface on STM32 boards; only in an image, behind the feature `stm32` |
//! | [`dead_reckoning`] | where the robot is by its own counts |
//! | [`pose_covariance`] | how sure that is |
//! | [`liveness`] | signs of life of the safety tasks |
//! | [`store`] | configuration, key and count of starts in a flash memory |
//! | [`odometry`] | counts x Q x W_T: the one place that knows W_T |
//! | [`units`] | physical quantities in fixed point, the control period |
#![cfg_attr(not(test), no_std)]

#[cfg(all(target_os = "none", feature = "stm32"))]
pub mod board;
pub mod dead_reckoning;
pub mod hal;
pub mod liveness;
pub mod pose_covariance;
pub mod probe;
pub mod shared;
pub mod store;
mod switching_on;
pub mod task;

pub use control::{
    capture, encoder, lines, odometry, pid, profile, protection, soft_float, supply, ticks, units,
    voltage,
};
