//! Effects that a user writes as an expression: fitted, tested, plotted and ranked like the built-in ones.
//!
//! ```text
//! d(target) = f(v, omega, ...; parameters) d(per)
//! ```
//!
//! | target | what it adds to | per |
//! | --- | --- | --- |
//! | `ds_left`, `ds_right` | the travel of that wheel \[m\] | second; metre rolled by that wheel; radian turned |
//! | `dtheta` | the heading, counter-clockwise \[rad\] | second; metre travelled; radian turned |
//! | `dn` | the position, to the left \[m\] | second; metre travelled; radian turned |
//!
//! Metres and radians count without a sign, forwards and backwards alike. A sign comes from the expression:
//! `v`, `omega` or `sign(v)`. Where an expression has no finite value, the effect does nothing.
//!
//! | variable | what it is |
//! | --- | --- |
//! | `v`, `v_left`, `v_right` | speed of the midpoint and of each wheel, forwards positive \[m/s\] |
//! | `omega` | turn rate, counter-clockwise positive \[rad/s\] |
//! | `a`, `a_left`, `a_right` | acceleration of the midpoint and of each wheel \[m/s^2\] |
//! | `theta` | heading in the fixed frame \[rad\] |
//! | `phi_left`, `phi_right` | angle of each wheel \[rad\] |
//! | `s` | path driven in this run, forwards or backwards \[m\] |
//! | `t`, `t_run` | time since the campaign's first run began, and since this run began \[s\] |
//! | `payload` | load on board \[kg\] |
//!
//! Every other name is a free parameter, four at most. The parameters in which the expression is linear, and
//! without which it vanishes, are its amplitudes; the others are shapes and say where it acts.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `equation.rs` | [`Custom`]: what a user writes, and how an equation is read |
//! | `target.rs` | [`Target`], [`Per`]: what it changes, and per what |
//! | `variables.rs` | the variables, and their values in a step |
//! | `analysis.rs` | where it grows without bound, which values are plausible |
//! | `build.rs` | [`CustomEffect`]: all of it as an effect |
//!
//! How a text is read, and which units follow, is in [`crate::expression`], for the motors' effects too.

mod analysis;
mod build;
mod equation;
mod target;
#[cfg(test)]
mod tests;
mod variables;

pub use build::CustomEffect;
pub use equation::Custom;
pub use target::{Per, Target};

/// The powers of metre, second and kilogram of a unit, as parameters declare it.
#[cfg(test)]
pub(super) fn dimensions(unit: &str) -> Result<[f64; 3], crate::expression::ExpressionProblem> {
    crate::expression::Unit::parse(unit).map(|unit| [unit.0[0], unit.0[1], unit.0[2]])
}
