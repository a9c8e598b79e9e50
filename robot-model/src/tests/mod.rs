//! Tests of the whole crate, on simulated recordings of robots of known truth.

mod coverage;
mod gear;
pub(crate) mod synthetic;
