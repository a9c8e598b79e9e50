//! Tuning of robots whose motors nobody knows: two decades of motor size, and how each is judged.

pub mod outcome;
pub mod robots;
pub mod robustness;
