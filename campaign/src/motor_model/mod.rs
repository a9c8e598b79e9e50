//! `motors.toml`: the effects that a user has put into the model of the motors, with the values that were fitted last; and
//! effects of the user's own.
//!
//! ```toml
//! [[effect]]
//! id = "backlash"
//! parameters.beta = { value = 0.0011, half_width_95 = 0.0002, unit = "m" }
//!
//! [[custom]]
//! id = "rubs"
//! equation = "dkS_right = k * max(0, cos(phi))"
//! unit.k = "V"
//! range.k = [0.0, 2.0]
//! ```
//!
//! The ids make the model. Whoever uses it fits the values to the experiments at hand. A `[[custom]]` declares an effect as a
//! further candidate for `explain --drivetrain`; only an `[[effect]]` of its id puts it into the model.

mod read;
#[cfg(test)]
mod tests;
mod write;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use robot_model::drivetrain::{CustomMotorEffect, KnownMotorEffect, MotorCustom, MotorEffect};
use robot_model::expression::ExpressionError;
use serde::Deserialize;

use crate::CampaignError;
use crate::equation_words::{About, free_id};

/// A model of the motors as in `motors.toml`.
#[derive(Clone, Debug, Default)]
pub struct MotorModelFile {
    /// The user's own effects, declared.
    pub customs: Vec<Arc<CustomMotorEffect>>,
    /// The effects of the model, in their order.
    pub effects: Vec<MotorModelEntry>,
}

/// One effect.
#[derive(Clone, Debug)]
pub struct MotorModelEntry {
    /// The effect.
    pub effect: KnownMotorEffect,
    /// Its values when it was fitted last, by name; empty before.
    pub values: BTreeMap<String, FittedValue>,
}

/// The value of a parameter.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FittedValue {
    /// The value.
    pub value: f64,
    /// Half the width of its 95 % interval, if these experiments tell it.
    pub half_width_95: Option<f64>,
    /// Its unit; `1` for a ratio.
    pub unit: Option<String>,
}

impl MotorModelFile {
    /// The file with the model of a campaign's motors.
    pub fn place(campaign: &Path) -> PathBuf {
        campaign.join("motors.toml")
    }

    /// The effects alone.
    pub fn chosen(&self) -> Vec<KnownMotorEffect> {
        self.effects.iter().map(|entry| entry.effect.clone()).collect()
    }

    /// The effect of this id, of the catalogue or of the user's own.
    pub fn find(&self, id: &str) -> Option<KnownMotorEffect> {
        KnownMotorEffect::find(id, &self.customs)
    }

    /// All candidates: the catalogue and the user's own effects.
    pub fn catalogue(&self) -> Vec<KnownMotorEffect> {
        KnownMotorEffect::all(&self.customs)
    }

    /// What to say where an effect is unknown.
    pub fn ids(&self) -> String {
        let catalogue = self.catalogue();
        let ids: Vec<&str> = catalogue.iter().map(|effect| effect.facts().id).collect();
        format!("one of {}", ids.join(", "))
    }

    /// Declares an effect of the user's own. If its id is taken, a number is added to it.
    pub fn declare(
        &mut self,
        custom: &MotorCustom,
    ) -> Result<KnownMotorEffect, Box<ExpressionError>> {
        let mut custom = custom.clone();
        let is_taken = |id: &str| self.customs.iter().any(|own| own.facts().id == id);
        custom.id = free_id(custom.id, is_taken);
        let effect = Arc::new(custom.build().map_err(Box::new)?);
        self.customs.push(Arc::clone(&effect));
        Ok(KnownMotorEffect::Own(effect))
    }
}

/// Reads an equation from a command line; the error shows it with a caret.
pub fn motor_custom_from_equation(text: &str) -> Result<MotorCustom, CampaignError> {
    MotorCustom::from_equation(text).map_err(|error| motor_equation_error(text, &error))
}

/// An error in an equation of the motors, with its column and a caret.
pub fn motor_equation_error(text: &str, error: &ExpressionError) -> CampaignError {
    About::Motors.error(text, error)
}
