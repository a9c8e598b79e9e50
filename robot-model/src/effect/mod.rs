//! Effects: ways in which a real robot departs from the nominal one. One effect a file, one shape.
//!
//! Each step, every effect of a model says what it changes, from what the wheels did; the changes of
//! all effects are put together in one place (`composition.rs`):
//!
//! ```text
//! ds_i   = R (dphi_i + sum angle_i) prod (1 + travel_i)                              (1)
//! dtheta = (ds_R - ds_L) / b  prod (1 + turning) + sum turn                          (2)
//! dn     = sum sideways,     world drift = sum drift                                 (3)
//! z      = pose(t - sum delay), its point moved by sum offset on the body            (4)
//! gyro   = omega + what the sensor adds                                              (5)
//! ```
//!
//! At zero every effect is the exact identity. The derivatives come with the values ([`crate::numeric::Jet`]).
//!
//! | file | what it holds |
//! | --- | --- |
//! | `definition.rs` | the trait [`Effect`], what it returns, and its [`Facts`] |
//! | `catalogue/` | the built-in effects, one a file |
//! | [`custom`] | effects that a user writes as an expression |
//! | `known.rs` | [`KnownEffect`]: an effect to keep, built in or a user's own |
//! | `composition.rs` | equations (1) to (3) and (5) for all effects of a model together |
//! | `net_change.rs` | what an effect comes to in the runs of a campaign, in one number |
//!
//! What the parameters are is estimated in [`crate::estimation`]; which effects a robot has is decided in
//! [`crate::selection`].

pub(crate) mod catalogue;
pub(crate) mod composition;
pub mod custom;
pub(crate) mod definition;
pub(crate) mod known;
pub(crate) mod net_change;
#[cfg(test)]
mod tests;

pub use catalogue::{CATALOGUE, find};
pub use custom::{Custom, CustomEffect};
pub use definition::{
    ActsOn, Change, Effect, Facts, FirmwareTerm, Group, Memory, Need, Parameter, Role, View,
};
pub use known::KnownEffect;
pub use net_change::{NetChange, Ways};
