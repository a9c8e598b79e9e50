//! Effects: how does a real robot differ from the nominal one? One effect per file, all of one form.
//!
//! In each step, every effect of a model gives its changes, from what the wheels did. `composition.rs` puts the
//! changes of all effects together:
//!
//! ```text
//! ds_i   = R (dphi_i + sum angle_i) prod (1 + travel_i)                              (1)
//! dtheta = (ds_R - ds_L) / b  prod (1 + turning) + sum turn                          (2)
//! dn     = sum sideways,     world drift = sum drift                                 (3)
//! z      = pose(t - sum delay), its point moved by sum offset on the body,
//!          its heading by sum drift times the time in the run                        (4)
//! gyro   = omega + what the sensor adds                                              (5)
//! ```
//!
//! At zero every effect is the exact identity. The derivatives come with the values ([`crate::numeric::Jet`]).
//!
//! | file | what it holds |
//! | --- | --- |
//! | `definition.rs` | the trait [`Effect`], what it returns, and its [`Facts`] |
//! | `catalogue/` | the built-in effects, one per file |
//! | [`custom`] | effects that a user writes as an expression |
//! | `known_effect.rs` | [`KnownEffect`]: an effect by its id, built in or a user's own |
//! | `composition.rs` | equations (1) to (4) for all effects of a model together |
//! | `slopes.rs` | how travel and turn of a step depend on every free parameter |
//! | `net_change.rs` | [`NetChange`]: what an effect adds up to over a campaign, in one number |
//!
//! [`crate::estimation`] fits the parameters, `selection` decides which effects a robot has.

pub(crate) mod catalogue;
pub(crate) mod composition;
pub mod custom;
pub(crate) mod definition;
pub(crate) mod known_effect;
pub(crate) mod net_change;
pub(crate) mod slopes;
#[cfg(test)]
mod tests;

pub use catalogue::{CATALOGUE, find};
pub use custom::{Custom, CustomEffect};
pub use definition::{
    ActsOn, Change, Effect, Facts, FirmwareTerm, Group, Memory, Need, Parameter, Role, View,
};
pub use known_effect::KnownEffect;
pub use net_change::{NetChange, Ways};
