//! Is it the radius at all? One run forwards and one backwards tell unequal radii from a pull.
//!
//! Unequal radii turn the robot one way forwards and the other way backwards. A pull (a caster that drags, a slope,
//! a crooked tyre) turns it the same way on every metre, in either direction. With alpha clockwise positive and p
//! the pull per metre driven:
//!
//! ```text
//! alpha = (R_L phi_L - W_T R_L phi_R) / b + p |s|,   s = R_L phi_L - b alpha / 2      (1)
//! ```
//!
//! For wheels that turn equally far out and back this is alpha_forward = A + P,
//! alpha_backward = -A + P. Each run gives one equation (1), linear in W_T and p.
//!
//! **How sure.** The two alphas may have errors in common, so their covariance counts. An error of the nominal
//! robot changes the part that flips in proportion to it:
//!
//! ```text
//! dW_T = A / (R phi_R) db,   dW_T = -n A b / (R phi_R) dR / R                          (2)
//! ```
//!
//! with n = 0 where the length of the path was measured, 1 where only the angle was, and 2 where the angle was
//! computed from an offset and the nominal length.
//!
//! Other causes are left to [`crate::explain`].
//!
//! | file | what it holds |
//! | --- | --- |
//! | `separation.rs` | [`OutAndBack::new`]: from two angles |
//! | `readings.rs` | [`OutAndBack::by_readings`]: from two readings by hand |

mod readings;
mod separation;
#[cfg(test)]
mod tests;

pub use separation::{CurvatureCause, Leg, MeasuredBy, OutAndBack, OutAndBackError, Shared};
