//! Tests of everything together, on recordings of robots that are known.

mod coverage;
mod gear;
pub(crate) mod synthetic;
