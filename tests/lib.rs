//! End to end.

pub mod judge;
pub mod robot;
