//! Which effects can the data not tell apart? For each effect of a model, its rivals: those that would explain as
//! much.
//!
//! Each other effect takes the effect's place in turn, and everything is fitted anew. If that loses less than three
//! sigma (9 in -2 log likelihood), the rival is as good an answer and is named together with the effect. The same
//! holds if it loses less than a fiftieth of what the effect explains: a difference so small may come from anything
//! that no model has. The data decide; there is no list of confounded effects.
//!
//! The screening is linear about the fitted effect. For a strong effect its error is a share of what the effect
//! explains, so every rival that comes near is fitted in full.

use crate::effect::composition::Term;
use crate::estimation::fit::{Fitted, fit_parameters};
use crate::recording::campaign::Prepared;
use crate::selection::candidates::{Candidate, RIVAL_MARGIN, Screening, penalty};
use crate::selection::effect_test::{EffectTest, OWN_SHARE_MIN};

/// A rival has to reproduce this share of what the effect does: where an effect is weak, chance alone gives
/// others nearly as much gain.
const RESEMBLANCE_MIN: f64 = 0.3;

/// Error of the screening, as a share of what the effect explains.
const SCREENING_ERROR: f64 = 0.1;

/// An effect's class: everything that this campaign cannot tell from it.
#[derive(Clone, Debug)]
pub(crate) struct Class<'a> {
    /// Rivals, best first, the chosen effect not included.
    pub rivals: Vec<Candidate<'a>>,
}

/// The class of each effect of the model.
pub(crate) fn classes<'a>(
    prepared: &Prepared,
    fitted: &Fitted<'a>,
    screening: &Screening<'a>,
    kept: &[EffectTest],
) -> Vec<Class<'a>> {
    let mut classes = Vec::new();
    for (index, test) in kept.iter().enumerate() {
        // Where runs scatter more than their noise, sigmas are wider.
        let sigmas = RIVAL_MARGIN * test.dispersion;
        let margin = sigmas.max(OWN_SHARE_MIN * test.gain);
        let own = test.gain - penalty(screening.term(index));
        let mut rivals: Vec<Candidate<'a>> = screening
            .candidates_that_gain(&[index], own - margin - SCREENING_ERROR * test.gain)
            .into_iter()
            .filter(|rival| !rival.test.implausible)
            .filter(|rival| screening.resemblance(index, &rival.term) > RESEMBLANCE_MIN)
            .filter(|rival| loss(prepared, fitted, index, &rival.term.fixed()) < margin)
            .collect();
        let net = |rival: &Candidate<'_>| rival.test.gain - penalty(&rival.term);
        rivals.sort_by(|a, b| net(b).total_cmp(&net(a)));
        classes.push(Class { rivals });
    }
    classes
}

/// How much -2 log likelihood rises, penalties included, with a rival in an effect's place.
fn loss<'a>(prepared: &Prepared, fitted: &Fitted<'a>, index: usize, rival: &Term<'a>) -> f64 {
    let mut terms = fitted.terms.clone();
    let own = std::mem::replace(&mut terms[index], rival.clone());
    let with = fit_parameters(prepared, terms, fitted.noise);
    with.chi_squared - fitted.chi_squared + penalty(rival) - penalty(&own)
}
