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

pub mod advice;
pub mod geometry;
pub mod out_and_back;
pub mod path;
pub mod track_fit;
pub mod wheel_weight;

mod mixed_model;
#[cfg(test)]
mod noise;

pub use advice::Advice;
pub use geometry::{Geometry, Turns};
pub use out_and_back::{Leg, OutAndBack, Verdict};
pub use path::Pose;
pub use track_fit::{FitOptions, Track, TrackFit, TrackSample, WheelAngles, fit_track};
pub use wheel_weight::{Contribution, Deviation, Experiment, Source, WheelWeight};
