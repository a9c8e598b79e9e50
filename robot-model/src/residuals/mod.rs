//! Residuals: does what a model leaves depend on anything?
//!
//! | file | what it holds |
//! | --- | --- |
//! | `unexplained.rs` | all tests together; [`Unexplained`] |
//! | `regressor.rs` | [`Regressor`]: what they may depend on |
//! | `probe.rs` | small effects in proportion to speed, load, heading and the like |
//! | `floor_location.rs` | places on the floor, coarsely and then closer |
//! | `ripple.rs` | ripples many times a wheel's turn |
//! | `heavy_tails.rs` | residuals with heavier tails than noise has |
//!
//! They point at what is missing and name no effect: that is [`crate::selection`].

pub(crate) mod floor_location;
pub(crate) mod heavy_tails;
pub(crate) mod probe;
pub(crate) mod regressor;
pub(crate) mod ripple;
pub(crate) mod unexplained;

pub use floor_location::PlaceSeen;
pub use regressor::Regressor;
pub use unexplained::Unexplained;
