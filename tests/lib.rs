//! End-to-end tests: what they share. Robots in virtual time, verdicts on calibrations, the blind benchmark, the
//! shipped scenarios.

pub mod blind;
pub mod calibration;
pub mod chaos;
pub mod drivetrain;
pub mod parallel;
pub mod robot;
pub mod scenarios;
pub mod tuning;
