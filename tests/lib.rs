//! End to end.

pub mod blind;
pub mod judge;
pub mod parallel;
pub mod robot;
