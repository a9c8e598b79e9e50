//! An effect to keep: of the catalogue, or a user's own.

use core::ops::Deref;
use std::sync::Arc;

use super::catalogue::find;
use super::custom::CustomEffect;
use super::definition::Effect;

/// An effect of the catalogue, or a user's own, which is shared.
#[derive(Clone, Debug)]
pub enum KnownEffect {
    /// Of the catalogue.
    BuiltIn(&'static dyn Effect),
    /// A user's own.
    Own(Arc<CustomEffect>),
}

impl KnownEffect {
    /// The effect of this id: of these, or of the catalogue.
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
