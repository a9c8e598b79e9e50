//! The estimator's model of a robot: kinematics, effects, estimation, selection. Pure `f64`, no I/O.
//!
//! Conventions everywhere: x forward, y to the left, heading counter-clockwise positive; metres,
//! radians, seconds. The one exception is the paper's deviation angle `alpha`, which is positive to
//! the right (clockwise) and is always called `alpha`.
//!
//! | room | what it answers | main items |
//! | --- | --- | --- |
//! | [`kinematics`] | where does the robot go when its wheels turn? | [`kinematics::Pose`], [`kinematics::Geometry`], [`kinematics::WheelPair`] |
//! | [`calibration`] | what is W_T, and how sure is it? | [`calibration::WheelWeight`], [`calibration::fit_track`], [`calibration::OutAndBack`] |
//! | [`recording`] | what was driven and measured? | [`recording::Campaign`], [`recording::Recording`], [`recording::OdometryNoise`] |
//! | [`checks`] | can wheels and poses belong to one robot at all? | [`checks::data_hypotheses`], [`checks::DataFault`] |
//! | [`expression`] | what does an expression of a user's own mean? | [`expression::ExpressionError`] |
//! | [`effect`] | which effects are known, and what does each do to a step? | [`effect::Effect`], [`effect::CATALOGUE`], [`effect::Custom`] |
//! | [`explain`] | which effects are missing, and which run would tell more? | [`explain::explain`], [`explain::Answer`], [`explain::model::fit`] |
//! | [`compare`] | how far is a model off, where, and how much of it is noise? | [`compare::Comparer`] |
//! | [`fleet`] | what have many robots in common, who changes, who is unlike the others? | [`fleet::judge`] |
//! | [`estimation`] | which parameters, which noise? | [`estimation::ErrorPair`], [`estimation::Errors`] |
//! | [`clocks`] | do the clocks of wheels and poses agree? | [`clocks::ClockFound`] |
//! | [`residuals`] | does what is left depend on anything? | [`residuals::Unexplained`] |
//! | `selection` | which effects belong in a model? | behind [`explain::explain`] |
//! | [`drivetrain`] | how do the motors answer, and which gains make the wheels follow? | [`drivetrain::fit`], [`drivetrain::design`] |
//! | [`numeric`] | numerics that know nothing of robots | [`numeric::Jet`] |
//!
//! A room uses only those named before it here: numeric, expression, kinematics, drivetrain, recording, checks and calibration, effect,
//! estimation, clocks, selection, residuals, explain, compare and fleet.

pub mod calibration;
pub mod checks;
pub mod clocks;
pub mod compare;
pub mod drivetrain;
pub mod effect;
pub mod estimation;
pub mod explain;
pub mod expression;
pub mod fleet;
pub mod kinematics;
pub mod numeric;
pub mod recording;
pub mod residuals;
mod selection;
#[cfg(test)]
mod tests;
