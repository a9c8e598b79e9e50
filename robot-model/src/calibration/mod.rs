//! Calibration: what is W_T = R_R / R_L, and how sure is it?
//!
//! | folder or file | what it answers |
//! | --- | --- |
//! | [`wheel_weight`] | W_T from one reading at the end of a run: the paper's calculation |
//! | [`track_fit`] | W_T from a whole measured track |
//! | [`out_and_back`] | is it the radius at all, or a pull? |
//! | `next_measurement.rs` | which measurement would make W_T surer? |
//!
//! All of this needs one run or two, and three nominal numbers. Other effects take a campaign: [`crate::explain`].

pub(crate) mod next_measurement;
pub mod out_and_back;
pub mod track_fit;
pub mod wheel_weight;

pub use out_and_back::{CurvatureCause, Leg, OutAndBack, Shared};
pub use track_fit::{
    FitOptions, Track, TrackFit, TrackFitError, TrackSample, WheelAngles, fit_track,
};
pub use wheel_weight::{
    Action, Advice, Contribution, Deviation, Experiment, Source, WheelWeight, WheelWeightError,
};
