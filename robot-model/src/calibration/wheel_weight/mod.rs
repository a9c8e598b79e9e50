//! The paper's calculation: what wheel weight W_T follows from the deviation at the end of a run?
//!
//! Symbols: R_L radius of the left wheel, b track width, phi_L and phi_R the angles that the wheels
//! turned, dS_L = R_L phi_L and dS_R = W_T R_L phi_R their travels, s = (dS_L + dS_R) / 2 the length
//! of the path, alpha the deviation angle, **clockwise positive** (to the right, as in the paper).
//!
//! ```text
//! alpha = (dS_L - dS_R) / b                                  (3-3)
//! W_T   = (R_L phi_L - b alpha) / (R_L phi_R)                (3-6), for wheels that turn differently
//! alpha = atan(dy_A / dx)                                    (3-2), from the tangent at the end
//! y     = -s (1 - cos alpha) / alpha                         exact arc, from the lateral offset
//! ```
//!
//! The general (3-6) is the paper's for phi_L = phi_R = 2 pi g C_T / N. Driving backwards, phi and
//! s are negative and every equation stands as it is. Uncertainty is propagated to first order.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `experiment.rs` | [`Experiment`]: the reading at the end of a run, and the propagation of its uncertainty |
//! | `arc.rs` | from an offset to an angle |
//! | `weight.rs` | [`WheelWeight`] |
//! | `uncertainty.rs` | [`Source`]s of uncertainty |
//! | `error.rs` | [`WheelWeightError`] |
//!
//! [`Experiment::wheel_weight`] is in `calibration/advice.rs`, with the advice that it gives.

pub(crate) mod arc;
pub(crate) mod error;
pub(crate) mod experiment;
#[cfg(test)]
mod tests;
pub(crate) mod uncertainty;
pub(crate) mod weight;

pub use crate::numeric::distributions::SIGMAS_95;
pub use error::WheelWeightError;
pub use experiment::{Deviation, Experiment};
pub use uncertainty::{Contribution, Source};
pub use weight::{Action, Advice, WheelWeight};
