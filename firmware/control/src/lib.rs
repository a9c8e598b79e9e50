//! What a Beeline robot works out at every control tick, two wheels in a millisecond.
//!
//! Steps in fixed point that know nothing of tasks, clocks or hardware: state and inputs in, outputs out.
//! A package of its own because an image wants these few steps quick and everything else small: the
//! compiler is told so by package (`firmware/.cargo/config.toml`). What plans and configures, outside the tick,
//! is marked `#[inline]`: not to be merged into its caller, but to be compiled with it, small.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`capture`] | both counters to counts, travel and speed |
//! | [`encoder`] | counts without end, and speed from counts |
//! | [`odometry`] | counts x Q x W_T: the one place that knows W_T |
//! | [`profile`] | trapezoids, exact for 10 km in integers |
//! | [`pid`] | feedforward and PID on travel |
//! | [`protection`] | what watches the wheels while the loop is closed |
//! | [`soft_float`] | double precision for what is planned and configured |
//! | [`units`] | physical quantities in fixed point, the control period |
#![cfg_attr(not(test), no_std)]

pub mod capture;
pub mod encoder;
pub mod odometry;
pub mod pid;
pub mod profile;
pub mod protection;
pub mod soft_float;
pub mod units;
