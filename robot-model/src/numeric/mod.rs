//! Numerics that know nothing of robots.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `jet.rs` | [`Jet`]: a value with its derivatives by an effect's parameters |
//! | `angle.rs` | wrapping of angles, sin(x) / x |
//! | `distributions.rs` | tails of the normal distribution, chi-squared and F, quantiles of Student's t, false discovery rates, half widths of 95 % intervals |
//! | `lanes.rs` | several numbers that go through the same arithmetic at once |
//! | `median.rs` | the median |
//! | `mixed_model.rs` | least squares with fixed and random unknowns (Henderson) |
//! | `parallel.rs` | a function of each item, on all cores |
//! | `random.rs` | a small seeded generator of normal numbers |

pub(crate) mod angle;
pub(crate) mod distributions;
pub(crate) mod jet;
pub(crate) mod lanes;
pub(crate) mod median;
pub(crate) mod mixed_model;
pub(crate) mod parallel;
pub(crate) mod random;

pub use distributions::students_t_quantile;
pub use jet::{Jet, PARAMETERS_MAX};
