//! What has been asked of a screening: the same questions come again and again in a search, and each takes a pass over
//! all runs.

use std::sync::OnceLock;

use crate::estimation::errors::TrackErrors;
use crate::selection::effect_test::EffectTest;

/// The answers that are known.
pub(super) struct Answers {
    /// The test of each effect of the model.
    pub kept: OnceLock<Vec<EffectTest>>,
    /// Of each candidate, the index of its term, and its test.
    pub candidates: OnceLock<Vec<(usize, EffectTest)>>,
    /// The tracks without each effect of the model, and at the end with all.
    pub tracks: Vec<OnceLock<Option<TrackErrors>>>,
}

impl Answers {
    /// Nothing has been asked about a model of so many effects.
    pub fn none(in_model: usize) -> Self {
        let tracks = (0..=in_model).map(|_| OnceLock::new()).collect();
        Self { kept: OnceLock::new(), candidates: OnceLock::new(), tracks }
    }
}

/// The answer, found now if it is not known.
///
/// No thread waits here for another one: while one of rayon's threads waits for a part of its work it may begin another
/// piece that asks the same.
pub(super) fn known<T>(answer: &OnceLock<T>, find: impl FnOnce() -> T) -> &T {
    if let Some(known) = answer.get() {
        return known;
    }
    let found = find();
    answer.get_or_init(|| found)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn a_question_is_worked_out_once_also_if_it_comes_up_while_it_is_worked_out() {
        let (answer, times) = (OnceLock::new(), Cell::new(0));
        let find = || {
            times.set(times.get() + 1);
            7
        };
        assert_eq!(known(&answer, || *known(&answer, find)), &7);
        assert_eq!(known(&answer, find), &7);
        assert_eq!(times.get(), 1);
    }
}
