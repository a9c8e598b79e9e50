//! Residuals: do they depend on anything that no effect of the model explains?
//!
//! | file | what it holds |
//! | --- | --- |
//! | `unexplained.rs` | [`Unexplained`]: the results of all tests |
//! | `regressor.rs` | [`Regressor`]: what they may depend on |
//! | `auxiliary_effects.rs` | small effects in proportion to speed, load, heading and the like |
//! | `flexible_model.rs` | the reachable error: what a model of any shape could reach |
//! | `group_search.rs` | which groups of functions it takes up |
//! | `basis_functions.rs` | its functions |
//! | `wheel_rates.rs` | one wheel's travel above several rates |
//! | `expression.rs` | [`Expression`]: the simple equation that would do nearly as well |
//! | `floor_location.rs` | places on the floor, by a coarse and a fine search |
//! | `ripple.rs` | ripples many times per turn of a wheel |
//! | `heavy_tails.rs` | heavier tails than a normal distribution has |
//! | `worth.rs` | how far what they depend on moves the robot |
//! | `each_run.rs` | what most runs show, each by itself |
//! | `innovations.rs` | what each pose shows that those before it did not tell |
//! | `whiteness.rs` | errors that persist over seconds, or over halves of runs |
//! | `lack_of_fit.rs` | errors that come back when a run is driven again |
//! | `place_waves.rs` | turns in waves over the floor |
//! | `campaign_times.rs` | functions of the time in the campaign |
//! | `uneven_runs.rs` | a few runs that are off by far more than the others |
//! | `sudden_motion.rs` | [`SuddenMotion`]: a robot that at once moved as its wheels did not |
//!
//! The tests name a quantity, such as speed or load, and no effect: that is left to `selection`.

pub(crate) mod auxiliary_effects;
pub(crate) mod basis_functions;
pub(crate) mod campaign_times;
mod each_run;
pub(crate) mod expression;
pub(crate) mod flexible_model;
pub(crate) mod floor_location;
pub(crate) mod group_search;
pub(crate) mod heavy_tails;
mod innovations;
pub(crate) mod lack_of_fit;
pub(crate) mod place_waves;
pub(crate) mod regressor;
pub(crate) mod ripple;
pub(crate) mod sudden_motion;
pub(crate) mod uneven_runs;
pub(crate) mod unexplained;
pub(crate) mod wheel_rates;
pub(crate) mod whiteness;
mod worth;

pub use expression::Expression;
pub use floor_location::PlaceSeen;
pub use lack_of_fit::DrivenAgain;
pub use regressor::Regressor;
pub use sudden_motion::SuddenMotion;
pub use unexplained::Unexplained;
