//! An effect by its id: of the catalogue, or a user's own.
//!
//! What it does is left to [`super::catalogue`] and [`super::custom`]. It is owned, so that what is made of a `model.toml`
//! borrows from nobody. An effect of the catalogue lives as long as the program; one of the user's own as long as somebody
//! holds it. What only looks at effects takes `&dyn Effect`.

use core::ops::Deref;
use std::sync::Arc;

use super::catalogue::find;
use super::custom::CustomEffect;
use super::definition::Effect;

/// An effect of the catalogue, or a shared one of the user's own.
#[derive(Clone, Debug)]
pub enum KnownEffect {
    /// An effect of the catalogue.
    BuiltIn(&'static dyn Effect),
    /// An effect of the user's own.
    Own(Arc<CustomEffect>),
}

impl KnownEffect {
    /// The effect with this id, from `own` or from the catalogue.
    pub fn find(id: &str, own: &[Arc<CustomEffect>]) -> Option<Self> {
        let own = own.iter().find(|effect| effect.facts().id == id).cloned().map(Self::Own);
        own.or_else(|| find(id).map(Self::BuiltIn))
    }
}

impl Deref for KnownEffect {
    type Target = dyn Effect;

    fn deref(&self) -> &(dyn Effect + 'static) {
        match self {
            Self::BuiltIn(effect) => *effect,
            Self::Own(effect) => effect.as_ref(),
        }
    }
}
