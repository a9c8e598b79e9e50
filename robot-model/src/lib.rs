//! What we believe about a robot: kinematics, fitting, judgement. Pure `f64`, no I/O.
//!
//! Conventions everywhere: x forward, y to the left, heading counter-clockwise positive; metres,
//! radians, seconds. The one exception is the paper's deviation angle `alpha`, which is positive to
//! the right (clockwise) and is always called `alpha`.
//!
//! | module | what it answers |
//! | --- | --- |
//! | [`geometry`] | what is nominal, and how well it is known |
//! | [`path`] | where does the robot go when its wheels turn so far? |
//! | [`wheel_weight`] | what is W_T, from one reading at the end of a run, and how sure is it? |
//! | [`advice`] | which measurement would make it surer? |
//! | [`track_fit`] | what is W_T, from a whole measured track? |
//! | [`out_and_back`] | is it the radius at all, or a pull? |
//!
//! And which physical effect is missing from the model?
//!
//! | module | what it answers |
//! | --- | --- |
//! | [`campaign`], [`recording`], [`run_kind`] | what was driven and measured? |
//! | [`effect`] | which effects are known, and what does each do to a step? |
//! | [`predict`], [`motion`], [`jet`] | where does a model put the robot, and how does that depend on its parameters? |
//! | [`effect::custom`] | effects that a user writes as an expression |
//! | [`odometry_noise`] | what is noise? |
//! | [`compare`] | how far is a model off, where, and how much of it is noise? |
//! | [`model`] | the parameters of chosen effects |
//! | [`next_run`] | which run would tell more? |
//! | [`explain`], [`answer`], [`structure`] | what is missing, what cannot be told apart, what stays unexplained? |

pub mod advice;
pub mod answer;
mod aside;
pub mod campaign;
mod combination;
pub mod compare;
pub mod effect;
mod errors;
pub mod explain;
pub mod gate;
pub mod geometry;
pub mod jet;
pub mod motion;
pub mod out_and_back;
mod parallel;
pub mod path;
pub mod plan;
pub mod predict;
pub mod recording;
pub mod run_kind;
pub mod sides;
pub mod track_fit;
pub mod wheel_weight;

mod classes;
#[cfg(test)]
mod coverage_tests;
mod evidence;
mod fit;
#[cfg(test)]
mod gear_tests;
mod gyro;
mod increment;
mod judge;
mod legs;
mod look;
mod mixed_model;
pub mod model;
pub mod next_run;
mod noise;
pub mod odometry_noise;
mod profile;
mod ripple;
mod select;
mod state;
pub mod structure;
#[cfg(test)]
mod synthetic;
mod tail;
mod unevenness;
mod whiten;

pub use advice::Advice;
pub use geometry::{Geometry, Turns};
pub use out_and_back::{Leg, OutAndBack, Shared, Verdict};
pub use path::Pose;
pub use track_fit::{FitOptions, Track, TrackFit, TrackSample, WheelAngles, fit_track};
pub use wheel_weight::{Contribution, Deviation, Experiment, Source, WheelWeight};
