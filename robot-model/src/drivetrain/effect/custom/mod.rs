//! Effects of motors that a user writes as an expression, in volts: fitted, tested and ranked like the built-in ones.
//!
//! | left side | what it adds to | unit |
//! | --- | --- | --- |
//! | `dV` | the voltage that a motor needs: positive brakes a wheel that rolls forwards | V |
//! | `dkS` | its friction, which never drives | V |
//! | `dkV` | its back-EMF constant, with viscous friction | V s/m |
//! | `dkA` | its inertia | V s^2/m |
//!
//! Each is for both motors, or for one: `dV_left`, `dkS_right`. Where an expression has no finite value, the effect does nothing.
//!
//! | variable | what it is |
//! | --- | --- |
//! | `v`, `v_other` | speed of this wheel and of the other one, forwards positive \[m/s\] |
//! | `volts`, `volts_other` | voltage that is applied to this wheel's motor and to the other one \[V\] |
//! | `load` | what this wheel's motor works against: its voltage less kV v \[V\] |
//! | `phi` | angle of this wheel since its counter was zero \[rad\] |
//! | `theta` | heading of the robot since the campaign began, left positive \[rad\] |
//! | `t` | time since the campaign began \[s\] |
//! | `side` | 1 for the left wheel, -1 for the right one |
//!
//! How a text is read, and which units follow, is in [`crate::expression`]; every other name is a free parameter.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `equation.rs` | [`MotorCustom`]: what a user writes, and how an equation is read |
//! | `target.rs` | [`MotorTarget`]: what it changes, and of which motor |
//! | `variables.rs` | the variables, and their values in a moment |
//! | `plausible.rs` | where it grows without bound, which values are plausible |
//! | `build.rs` | [`CustomMotorEffect`]: all of it as an effect |

mod build;
mod equation;
mod plausible;
mod target;
#[cfg(test)]
mod tests;
mod variables;

pub use build::CustomMotorEffect;
pub use equation::MotorCustom;
pub use target::{MotorTarget, Motors};
