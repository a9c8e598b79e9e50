//! How do the motors answer to a voltage, and which gains make the wheels follow?
//!
//! Everything is in travel of a wheel \[m\] and in volts at its motor, for both wheels at once. A robot couples its
//! wheels: what one pushes, the other feels.
//!
//! ```text
//! V_L = kS sign(v_L) + kV v_L + kA a_L + kC a_R             V delayed by tau                  (1)
//! V_R = kS sign(v_R) + kV v_R + kA a_R + kC a_L             kS by direction, all but kC, tau by wheel
//! ```
//!
//! A wheel at rest stays there while its friction can hold it. Straight on, a wheel has the inertia kA + kC; on the spot,
//! kA - kC.
//!
//! | file | what it answers |
//! | --- | --- |
//! | `recording.rs` | what was applied, and how far did the wheels go? |
//! | `model.rs` | (1): which travel follows from which voltage? |
//! | `regression.rs` | a first guess, from differentiated travel |
//! | `fit.rs` | which constants explain the travel best? |
//! | `intervals.rs` | how sure are they? |
//! | `push.rs` | does a slope or a cable push the robot? |
//! | `gains.rs` | which gains keep their margin with constants that are 30 % off? |
//! | `effect/` | which effects may motors have beyond (1)? |
//! | `missing/` | which of them do these motors have? |

pub mod effect;
mod fit;
mod gains;
mod intervals;
mod missing;
mod model;
mod push;
mod recording;
mod regression;
#[cfg(test)]
mod tests;

pub use effect::{MOTOR_CATALOGUE, MotorEffect, MotorFacts, MotorParameter, MotorRole};
pub use fit::{Constants, DrivetrainFit, FitError, HalfWidths, fit};
pub use gains::{Gains, GainsError, LoopFacts, design};
pub use missing::{
    BaselineErrors, EXPERIMENTS_MIN, Estimate, Experiment, ExperimentKind, KnownRobot,
    MissingError, MotorAnswer, MotorErrors, MotorStep, NextExperiment, Regressor, Remains, Tried,
    baseline_errors, missing,
};
pub use model::{Drivetrain, WheelMotor};
pub use push::Push;
pub use recording::{Sample, VoltageRecording};
pub use regression::regress;
