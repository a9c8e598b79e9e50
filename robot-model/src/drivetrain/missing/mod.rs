//! Where does the model of the motors fail, and which effect is missing?
//!
//! The travel that the voltages alone lead to is compared with the counts, experiment by experiment. Effects are added one
//! after the other where they predict experiments that they were not fitted to, beyond chance and by a size worth speaking of.
//!
//! | file | what it answers |
//! | --- | --- |
//! | `experiment.rs` | what was driven, and what is known about the robot? |
//! | `simulate.rs` | which travel follows from the voltages, with effects? |
//! | `least_squares.rs` | which constants explain it best, and how well do the others predict each experiment? |
//! | `alike.rs` | which experiments are alike, so that what the model misses moves their constants alike? |
//! | `modes.rs` | what do both wheels share, and what sets them apart? |
//! | `chance.rs` | is a gain more than chance? |
//! | `strength.rs` | is an effect that shows in few experiments more than chance? |
//! | `screening.rs` | which effects are worth a fit? |
//! | `selection.rs` | which does the model lack? |
//! | `classes.rs` | which can these experiments not tell apart? |
//! | `unexplained.rs` | does anything remain that no effect explains? |
//! | `voltage_changes.rs` | does the voltage lag where it changes? |
//! | `next_experiment.rs` | which experiment would tell more? |
//! | `answer.rs` | all of it |
//! | `chosen.rs` | does the model predict better with effects that a user has chosen? |

mod alike;
mod answer;
mod chance;
mod chosen;
mod classes;
mod experiment;
mod least_squares;
mod modes;
mod next_experiment;
mod screening;
mod selection;
mod simulate;
mod strength;
#[cfg(test)]
mod tests;
mod unexplained;
mod voltage_changes;

pub use answer::{
    BaselineErrors, EXPERIMENTS_MIN, Estimate, LeftOfTravel, MissingError, MotorAnswer,
    MotorErrors, MotorStep, Tried, baseline_errors, missing, missing_with,
};
pub use chosen::{ChosenEffect, ChosenModel, fit_chosen};
pub use experiment::{Experiment, KnownRobot};
pub use next_experiment::{ExperimentKind, NextExperiment};
pub use unexplained::{MotorRegressor, MotorUnexplained};
