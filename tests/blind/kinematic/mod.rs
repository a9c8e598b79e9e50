//! A second plant for the blind benchmark: kinematics alone, written from the definitions.
//!
//! It shares no line with `robot-model`, with the simulator's plant or with the firmware, and of `campaign` only the
//! types of files and rows. Wheels turn exactly as a trapezoid of speed wants them to; the robot follows by what its
//! wheels roll, in steps of a millisecond:
//!
//! ```text
//! ds_i = R_i dphi_i (1 + ...),  ds = (ds_L + ds_R)/2,  dtheta = (ds_R - ds_L)/b (1 + ...) + ...          (1)
//! x += ds cos(theta + dtheta/2) - dn sin(theta + dtheta/2),  y likewise,  theta += dtheta                (2)
//! ```
//!
//! Lengths \[m\], angles \[rad\], counter-clockwise and to the left positive; the left wheel is index 0, the right one 1.
//! The same run can be computed without noise, and without what is hidden, so that the true noise level is known.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`planned_run`] | which runs are driven, and how far each wheel has turned at each millisecond |
//! | [`mechanism`] | what can be hidden, with its true parameters and right regressors |
//! | [`mechanism_step`] | what each mechanism does in a step |
//! | [`drive`] | equations (1) and (2), and the noise of rolling |
//! | [`robot`] | a robot drawn by seed, and its recorded campaign |
//! | [`track_distance`] | how far two tracks lie apart, from the best start |

pub mod drive;
pub mod mechanism;
pub mod mechanism_step;
pub mod planned_run;
pub mod robot;
pub mod track_distance;

use rand::{Rng, RngExt};

/// A number of the standard normal distribution, by Box and Muller.
pub fn normal(rng: &mut impl Rng) -> f64 {
    let (radius, angle): (f64, f64) = (rng.random(), rng.random());
    // 1 - u is never zero.
    (-2.0 * (1.0 - radius).ln()).sqrt() * (core::f64::consts::TAU * angle).cos()
}
