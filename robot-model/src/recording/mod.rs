//! What was driven and measured: runs, campaigns, and what a run's wheels did step by step.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `run.rs` | [`Recording`]: one run as measured; [`Robot`], the data sheet that goes with it |
//! | `campaign.rs` | [`Campaign`]: all runs of one robot; prepared once, for every question that follows |
//! | `condense.rs` | dense recordings, made lighter before a fit |
//! | `motion.rs` | [`Step`]: turns, speeds, accelerations and reversals of the wheels |
//! | `run_kind.rs` | [`RunKind`]: straight, spin, arc, square, recognised from the motion |
//! | `repetitions.rs` | [`repetitions`]: which runs are the same motion driven again |
//! | `excitation.rs` | [`Excitation`]: what the runs of a campaign reached |
//! | `odometry_noise.rs` | [`OdometryNoise`] of poses, and of the odometry between them |
//! | `nominal_run.rs` | recordings of a nominal robot that drives given pieces |
//!
//! Files and their formats are the caller's. Whether a recording can be of one robot at all is checked in
//! [`crate::checks`].

pub(crate) mod campaign;
pub(crate) mod condense;
pub(crate) mod excitation;
pub(crate) mod motion;
pub(crate) mod nominal_run;
pub(crate) mod odometry_noise;
pub(crate) mod repetitions;
pub(crate) mod run;
pub(crate) mod run_kind;

pub use campaign::Campaign;
pub use excitation::Excitation;
pub use motion::Step;
pub use nominal_run::{Piece, Sampling, nominal_run};
pub use odometry_noise::OdometryNoise;
pub use repetitions::repetitions;
pub use run::{
    GyroSample, PoseMeasurement, Recording, RecordingError, RecordingProblem, Robot, WheelSample,
};
pub use run_kind::RunKind;
