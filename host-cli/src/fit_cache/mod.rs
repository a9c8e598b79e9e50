//! What was found in campaigns, kept in the user's cache folder: `explain`, `report`, `apply`, `compare` and `serve` fit
//! a campaign once.
//!
//! What is kept is found again by a hash of all that it came from, so it cannot be stale: a run that was recorded, edited or held out
//! since, another number in `robot.toml`, another equation of the user's, or another build of this program are another
//! entry. Only what takes long is kept, as numbers to the last bit: sentences, tables and pages are made of it by the same code as
//! of a fresh fit.
//!
//! | file | what it holds |
//! | --- | --- |
//! | `key.rs` | the hash |
//! | `store.rs` | the files: whole or not at all, so many at most |
//!
//! No error here is the user's: what cannot be read is fitted, and what cannot be written is fitted again.

mod key;
mod store;

use std::sync::atomic::{AtomicBool, Ordering};

use campaign::model::ModelFile;
use robot_model::compare::Comparer;
use robot_model::effect::Effect;
use robot_model::explain::Answer;
use robot_model::recording::{Campaign, OdometryNoise, RecordingError};

use self::key::Key;
use self::store::Store;
use crate::ui::{DIM, note, paint};

/// What `explain` is asked.
#[derive(Clone, Copy)]
pub struct Question<'a> {
    /// The runs.
    pub campaign: &'a Campaign,
    /// All candidate effects.
    pub catalogue: &'a [&'a dyn Effect],
    /// Ids of the effects that the model has already.
    pub in_model: &'a [&'a str],
}

/// What was found in campaigns.
pub struct FitCache {
    /// None if nothing is to be reused, or there is no place to keep it.
    store: Option<Store>,
    /// The user has been told, or is not to be.
    told: AtomicBool,
}

impl FitCache {
    /// That of the user, who is told when something of it is used, unless `quiet`.
    pub fn of_user(quiet: bool) -> Self {
        Self { store: Store::of_user(), told: AtomicBool::new(quiet) }
    }

    /// One that keeps nothing.
    pub fn none() -> Self {
        Self { store: None, told: AtomicBool::new(true) }
    }

    /// The answer to a question: as it is known, or as `explain` gives it, which is then kept.
    pub fn answer(
        &self,
        question: &Question<'_>,
        explain: impl FnOnce() -> Result<Answer, RecordingError>,
    ) -> Result<Answer, RecordingError> {
        let Some((store, noise_key)) = self.place(question.campaign, question.catalogue) else {
            return explain();
        };
        let key = Key::of_answer(&noise_key, question.in_model);
        if let Some(answer) = key.and_then(|key| store.read(&key)) {
            self.tell();
            return Ok(answer);
        }
        let answer = explain()?;
        if let Some(key) = key {
            store.write(&key, &answer);
        }
        store.write(&noise_key, &answer.compared_by);
        Ok(answer)
    }

    /// A campaign ready to be compared, given a model's own effects: its noise is known, or is estimated and kept.
    pub fn comparer(
        &self,
        campaign: &Campaign,
        model: &ModelFile,
    ) -> Result<Comparer, RecordingError> {
        let place = self.place(campaign, &model.catalogue());
        if let Some(noise) = place.and_then(|(store, key)| store.read::<OdometryNoise>(&key)) {
            self.tell();
            return Comparer::with_noise(campaign, noise);
        }
        let comparer = Comparer::new(campaign, &model.own().collect::<Vec<&dyn Effect>>())?;
        if let Some((store, key)) = place {
            store.write(&key, comparer.noise());
        }
        Ok(comparer)
    }

    /// Where the noise of a campaign is kept. The key is not computed if nothing is.
    fn place(&self, campaign: &Campaign, catalogue: &[&dyn Effect]) -> Option<(&Store, Key)> {
        let store = self.store.as_ref()?;
        Key::of_noise(campaign, catalogue).map(|key| (store, key))
    }

    fn tell(&self) {
        if !self.told.swap(true, Ordering::Relaxed) {
            let words =
                "nothing has changed since the last fit, which is reused; --no-cache fits again";
            note(paint(DIM, words));
        }
    }
}
