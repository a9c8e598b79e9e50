//! The control steps of a Beeline robot: what is computed for both wheels at every control tick.
//!
//! The steps work in fixed point and know nothing of tasks, clocks or hardware: state and inputs in,
//! outputs out. They are a package of their own so that the compiler optimises them for speed and the rest
//! of an image for size (`firmware/.cargo/config.toml` sets this per package). Planning and configuration,
//! outside the tick, are marked `#[inline]`: then they are compiled with their caller, for size.
//!
//! | module | contents |
//! | --- | --- |
//! | [`ticks`] | the control timer's ticks: late ones, and lost ones |
//! | [`capture`] | from both counters to counts, travel and speed |
//! | [`encoder`] | 64-bit counts, and speed from counts |
//! | [`lines`] | what a motor driver's lines do at a duty |
//! | [`odometry`] | counts x Q x W_T: the one place that knows W_T |
//! | [`profile`] | trapezoids, exact for 10 km in integers |
//! | [`pid`] | feedforward and PID on travel |
//! | [`protection`] | detects faults while the loop is closed |
//! | [`soft_float`] | small double-precision routines for planning and configuration |
//! | [`supply`] | duty for the supply at hand |
//! | [`voltage`] | voltages without feedback, to measure motors |
//! | [`units`] | physical quantities in fixed point, the control period |
#![cfg_attr(not(test), no_std)]

pub mod capture;
pub mod encoder;
pub mod lines;
pub mod odometry;
pub mod pid;
pub mod profile;
pub mod protection;
pub mod soft_float;
pub mod supply;
pub mod ticks;
pub mod units;
pub mod voltage;
