//! How do the motors answer to a voltage, and which gains make the wheels follow?
//!
//! Everything is in travel of a wheel \[m\] and in volts at its motor, for both wheels at once. A robot couples its
//! wheels: what one pushes, the other feels.
//!
//! ```text
//! V_L = kS sign(v_L) + kV v_L + kA a_L + kC a_R + kW v_R (v_R - v_L)             V delayed by tau                  (1)
//! V_R = kS sign(v_R) + kV v_R + kA a_R + kC a_L + kW v_L (v_L - v_R)             kS by direction, all but kC, kW, tau by wheel
//! ```
//!
//! kW: a robot that turns pushes its centre of mass, which is behind the axle, outwards. With the mass M, the centre of mass d behind
//! the axle, u and w the speed and the yaw rate, b the track width:
//!
//! ```text
//! F = M (u' + d w^2),   T = I w' - M d u w                                                                        (2)
//! kW = M d / b^2 in volts at one wheel                      negative with the centre of mass in front
//! ```
//!
//! The two terms of (2) do no work together. Source: Fierro and Lewis, Journal of Robotic Systems 14 (1997), 149, eq. (2).
//!
//! A wheel at rest stays there while its friction can hold it. Straight on, a wheel has the inertia kA + kC; on the spot,
//! kA - kC.
//!
//! | file | what it answers |
//! | --- | --- |
//! | `recording.rs` | what was applied, and how far did the wheels go? |
//! | `model.rs` | (1): which travel follows from which voltage? |
//! | `regression.rs` | a first guess, from differentiated travel |
//! | `residuals.rs` | how far is modelled travel from counts, which begin somewhere within one? |
//! | `constants_vector.rs` | the constants as a search moves through them |
//! | `fit.rs` | which constants explain the travel best? |
//! | `intervals.rs` | how sure are they? |
//! | `load_disturbance.rs` | does a slope or a cable push the robot? |
//! | `gains.rs` | which gains keep their margin with constants that are 30 % off? |
//! | `feedforward.rs` | what is missing in a feedforward, by what the loop adds to it? |
//! | `effect/` | which effects may motors have beyond (1)? |
//! | `missing/` | which of them do these motors have? |

mod constants_vector;
pub mod effect;
mod feedforward;
mod fit;
mod gains;
mod intervals;
mod load_disturbance;
mod missing;
mod model;
mod recording;
mod regression;
mod residuals;
#[cfg(test)]
mod tests;

pub use effect::{
    CustomMotorEffect, KnownMotorEffect, MOTOR_CATALOGUE, MotorCustom, MotorEffect, MotorFacts,
    MotorParameter, MotorRole, find as find_effect,
};
pub use feedforward::{Added, AddedTerms};
pub use fit::{Constants, DrivetrainFit, FitError, HalfWidths, fit};
pub use gains::{Gains, GainsError, LoopFacts, design};
pub use load_disturbance::LoadDisturbance;
pub use missing::{
    BaselineErrors, ChosenEffect, ChosenModel, EXPERIMENTS_MIN, Estimate, Experiment,
    ExperimentKind, KnownRobot, LeftOfTravel, MissingError, MotorAnswer, MotorErrors,
    MotorRegressor, MotorStep, MotorUnexplained, NextExperiment, Tried, baseline_errors,
    fit_chosen, missing, missing_with,
};
pub use model::{Drivetrain, WheelMotor};
pub use recording::{Sample, VoltageRecording};
pub use regression::regress;
