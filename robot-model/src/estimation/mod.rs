//! Estimation: which parameters has a given set of effects, and which noise goes with them?
//!
//! A run's measured poses go through an extended Kalman filter, which turns them into independent residuals and
//! their derivatives by every parameter. Their normal equations, one set a run, are all that later questions need.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `ekf.rs` | the filter over one run: innovations and their whitened derivatives |
//! | `state.rs` | the filter's state and covariance: predict, add process noise, update |
//! | `sensitivities.rs` | how the state depends on every parameter |
//! | `transition.rs` | one step of the pose, and its derivatives |
//! | `gyro.rs` | the same for the yaw rate sensor |
//! | `normal_equations.rs`, `row_adder.rs` | sums of whitened rows; what adds them up |
//! | `campaign_equations.rs` | those of all runs: solve, leave out, shift |
//! | `left_out.rs`, `blocks.rs` | what predicts a run that is left out; the blocks of one that must predict itself |
//! | `most_likely_noise.rs` | the most likely [`OdometryNoise`](crate::recording::OdometryNoise) |
//! | `noise_segments.rs` | segments between poses, from which the noise is estimated |
//! | `fit.rs` | parameters and noise of a model |
//! | `predict.rs` | open loop: where a model says that the robot went |
//! | `errors.rs` | [`Errors`] of predicted tracks, on runs fitted to and cross-validated |
//! | `tolerance.rs` | what is too small to matter |
//! | `profile_likelihood.rs` | intervals where the fit is not quadratic |
//!
//! Which effects belong in a model is decided in `selection`.

pub(crate) mod blocks;
pub(crate) mod campaign_equations;
pub(crate) mod ekf;
pub(crate) mod errors;
pub(crate) mod fit;
pub(crate) mod gyro;
pub(crate) mod left_out;
pub(crate) mod most_likely_noise;
pub(crate) mod noise_segments;
pub(crate) mod normal_equations;
pub(crate) mod predict;
pub(crate) mod profile_likelihood;
pub(crate) mod row_adder;
pub(crate) mod sensitivities;
pub(crate) mod state;
pub(crate) mod tolerance;
pub(crate) mod transition;

pub use crate::numeric::distributions::SIGMAS_95;
pub use errors::{ErrorPair, Errors};
