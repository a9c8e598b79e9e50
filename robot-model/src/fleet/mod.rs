//! Many robots and dates: what have all of a kind in common, who changes with time, and who is unlike the others?
//!
//! Every campaign of a kind is fitted with the same effects ([`common_effects`]), so that values can be compared. What is
//! asked of the values of one parameter ([`judge`]):
//!
//! ```text
//! x_rk = m + a_r + b_r (t_rk - mean t_r) + e_rk,   e_rk ~ N(0, phi sigma_rk^2)               (1)
//! a_r ~ N(0, tau^2)                                 robots of a kind differ by tau            (2)
//! phi = max(1, sum chi^2 / sum of its degrees)      dates scatter more than one fit says      (3)
//! ```
//!
//! tau is the estimate of DerSimonian and Laird (1986). A robot is an outlier by its distance from the mean of the others, over
//! their spread, its own uncertainty, and that of the mean (Student's t). All questions of a fleet are asked at once: what
//! counts has a false discovery rate (Benjamini and Hochberg) below [`RATE`].
//!
//! | file | what it holds |
//! | --- | --- |
//! | `common_effects.rs` | the effects that every campaign of a kind is fitted with |
//! | `robots.rs` | the values of one robot: mean and trend |
//! | `judgement.rs` | [`judge`]: what all have in common, trends and outliers |

mod common_effects;
mod judgement;
mod robots;

pub use common_effects::{Found, common_effects, is_wear};
pub use judgement::{Judgement, RATE, RobotJudged, judge};
pub use robots::{Measured, Trend};
