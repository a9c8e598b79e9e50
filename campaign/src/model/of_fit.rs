//! What a fit found, as a model.

use robot_model::explain::model::Model;
use robot_model::explain::{Answer, Averaged};

use super::{EffectEntry, FitEntry, ModelFile};

impl ModelFile {
    /// The model that an answer predicts other runs with, fitted to so many runs. `self` has the effects of the user's own.
    pub fn found(&self, answer: &Answer, runs: usize) -> Self {
        let entry = |found: &Averaged| {
            let entry = EffectEntry::unfitted(self.find(&found.effect)?);
            let (parameters, up_to_mps) = (found.parameters.clone(), found.up_to_mps);
            Some(EffectEntry { parameters, up_to_mps, ..entry })
        };
        Self {
            customs: self.customs.clone(),
            effects: answer.predicts_with.iter().filter_map(entry).collect(),
            fit: Some(FitEntry {
                runs,
                nominal: answer.baseline,
                errors: answer.predicts_by,
                noise: answer.noise,
            }),
        }
    }

    /// Takes the values of a fit of its effects, in their order, to so many runs.
    pub fn take_fit(&mut self, fitted: &Model, runs: usize) {
        for (entry, fitted) in self.effects.iter_mut().zip(&fitted.effects) {
            entry.parameters.clone_from(&fitted.parameters);
            entry.in_use = false;
        }
        self.fit = Some(FitEntry {
            runs,
            nominal: fitted.nominal,
            errors: fitted.errors,
            noise: fitted.noise,
        });
    }
}
