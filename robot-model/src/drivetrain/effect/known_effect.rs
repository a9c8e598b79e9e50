//! An effect of a motor by its id: of the catalogue, or a user's own.
//!
//! It is owned, so that models and answers borrow from nobody, as [`crate::effect::KnownEffect`] of the path.

use core::ops::Deref;
use std::sync::Arc;

use super::custom::CustomMotorEffect;
use super::definition::MotorEffect;
use super::{MOTOR_CATALOGUE, find};

/// An effect of the catalogue, or a shared one of the user's own.
#[derive(Clone, Debug)]
pub enum KnownMotorEffect {
    /// An effect of the catalogue.
    BuiltIn(&'static dyn MotorEffect),
    /// An effect of the user's own.
    Own(Arc<CustomMotorEffect>),
}

impl KnownMotorEffect {
    /// The effect with this id, from `own` or from the catalogue.
    pub fn find(id: &str, own: &[Arc<CustomMotorEffect>]) -> Option<Self> {
        let own = own.iter().find(|effect| effect.facts().id == id).cloned().map(Self::Own);
        own.or_else(|| find(id).map(Self::BuiltIn))
    }

    /// The catalogue, and then the user's own.
    pub fn all(own: &[Arc<CustomMotorEffect>]) -> Vec<Self> {
        let built_in = MOTOR_CATALOGUE.into_iter().map(Self::BuiltIn);
        built_in.chain(own.iter().cloned().map(Self::Own)).collect()
    }
}

impl Deref for KnownMotorEffect {
    type Target = dyn MotorEffect;

    fn deref(&self) -> &(dyn MotorEffect + 'static) {
        match self {
            Self::BuiltIn(effect) => *effect,
            Self::Own(effect) => effect.as_ref(),
        }
    }
}

/// The same effect: no two of a model have one id.
impl PartialEq for KnownMotorEffect {
    fn eq(&self, other: &Self) -> bool {
        self.facts().id == other.facts().id
    }
}
