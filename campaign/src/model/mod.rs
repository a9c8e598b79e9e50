//! `model.toml`: which effects a user has accepted, with their fitted values; and effects of the
//! user's own.
//!
//! ```toml
//! [[effect]]
//! id = "side_slip"
//! parameters.k = { value = 0.021, sigma = 0.001, low95 = 0.019, high95 = 0.023, unit = "s" }
//!
//! [[custom]]
//! id = "my_term"
//! target = "dtheta"
//! per = "second"
//! expression = "k * v^2 * omega"
//! unit.k = "s^2/m^2"
//! ```
//!
//! A `[[custom]]` declares an effect as a further candidate for `explain`; only an `[[effect]]` of
//! its id puts it into the model. `in_use = true` marks an effect that the robot compensated while
//! its runs were recorded, at the value in its configuration ([`in_use`]).

pub mod in_use;
mod of_fit;
mod read;
#[cfg(test)]
mod tests;
mod unchecked;
mod validate;
mod write;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use robot_model::compare::EffectWithValues;
use robot_model::effect::{CATALOGUE, Custom, CustomEffect, Effect, KnownEffect};
use robot_model::estimation::ErrorPair;
use robot_model::explain::ParameterFound;
use robot_model::expression::ExpressionError;
use robot_model::recording::OdometryNoise;

use crate::equation_words::free_id;

pub use read::{custom_from_equation, equation_error, hint_for};

/// A model as in `model.toml`.
#[derive(Clone, Debug, Default)]
pub struct ModelFile {
    /// The user's own effects, declared.
    pub customs: Vec<Arc<CustomEffect>>,
    /// The effects of the model, in their order.
    pub effects: Vec<EffectEntry>,
    /// How well the model fits, if it was fitted.
    pub fit: Option<FitEntry>,
}

/// One effect of the model.
#[derive(Clone, Debug)]
pub struct EffectEntry {
    /// The effect.
    pub effect: KnownEffect,
    /// Its fitted parameters; empty before a fit.
    pub parameters: Vec<ParameterFound>,
    /// The values are those that the robot compensated while the runs were recorded; nothing was
    /// fitted.
    pub in_use: bool,
    /// Faster than this it does what it does at this speed of the faster wheel \[m/s\]: that was the mean speed of the
    /// runs that it was found in, which cannot tell it from other effects.
    pub up_to_mps: Option<f64>,
}

impl EffectEntry {
    /// An entry without values yet.
    pub fn unfitted(effect: KnownEffect) -> Self {
        Self { effect, parameters: Vec::new(), in_use: false, up_to_mps: None }
    }

    /// The effect's id.
    pub fn id(&self) -> &str {
        self.effect.facts().id
    }
}

/// How well a fitted model describes its runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitEntry {
    /// How many runs it was fitted to.
    pub runs: usize,
    /// Errors of the nominal robot.
    pub nominal: ErrorPair,
    /// Errors of the model.
    pub errors: ErrorPair,
    /// The noise that was estimated with it.
    pub noise: OdometryNoise,
}

impl ModelFile {
    /// The file with the model of a campaign.
    pub fn place(campaign: &Path) -> PathBuf {
        campaign.join("model.toml")
    }

    /// The effect of this id, of the catalogue or of the user's own.
    pub fn find(&self, id: &str) -> Option<KnownEffect> {
        KnownEffect::find(id, &self.customs)
    }

    /// All candidates: the catalogue and the user's own effects.
    pub fn catalogue(&self) -> Vec<&dyn Effect> {
        let mut all: Vec<&dyn Effect> = CATALOGUE.to_vec();
        all.extend(self.own());
        all
    }

    /// The user's own effects.
    pub fn own(&self) -> impl Iterator<Item = &dyn Effect> {
        self.customs.iter().map(|own| own.as_ref() as &dyn Effect)
    }

    /// The effects of the model.
    pub fn chosen(&self) -> Vec<&dyn Effect> {
        self.effects.iter().map(|entry| &*entry.effect).collect()
    }

    /// The effects that the robot compensated while the runs were recorded, and that were not
    /// fitted since.
    pub fn in_use(&self) -> Vec<&EffectEntry> {
        self.effects.iter().filter(|entry| entry.in_use).collect()
    }

    /// The model at its fitted values; the error is the id of the first effect without values.
    pub fn effects_with_values(&self) -> Result<Vec<EffectWithValues<'_>>, &str> {
        fn effect_with_values(entry: &EffectEntry) -> Result<EffectWithValues<'_>, &str> {
            let facts = entry.effect.facts();
            let values: Option<Vec<f64>> = facts
                .parameters
                .iter()
                .map(|known| entry.parameters.iter().find(|found| found.name == known.name))
                .map(|found| found.map(|parameter| parameter.value))
                .collect();
            let up_to_mps = entry.up_to_mps;
            values
                .map(|values| EffectWithValues { effect: &*entry.effect, values, up_to_mps })
                .ok_or(facts.id)
        }
        self.effects.iter().map(effect_with_values).collect()
    }

    /// Declares an effect of the user's own. If its id is taken, a number is added to it.
    pub fn declare(&mut self, custom: &Custom) -> Result<KnownEffect, Box<ExpressionError>> {
        let mut custom = custom.clone();
        let is_taken = |id: &str| self.customs.iter().any(|own| own.facts().id == id);
        custom.id = free_id(custom.id, is_taken);
        let effect = Arc::new(custom.build().map_err(Box::new)?);
        self.customs.push(Arc::clone(&effect));
        Ok(KnownEffect::Own(effect))
    }
}
