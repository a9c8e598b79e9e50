//! What the data cannot tell apart: for each effect of a model, the rivals that would explain as much.
//!
//! An effect is taken out and each other effect put in its place, everything fitted anew. If that loses
//! less than three sigma, 9 in -2 log likelihood, the rival is as good an answer, and it is named in one
//! breath with the effect. The data decide: no list of confounds is kept. So it is if it loses next to nothing of
//! what the effect explains: of two that do the same to a fiftieth, anything that no model has decides.
//!
//! A first look is linear about the fitted effect; of a strong one the rivals' fits are off by a share of
//! what it explains. So whatever comes near is fitted in earnest.

use crate::effect::composition::Term;
use crate::estimation::fit::{Fitted, fit_parameters};
use crate::recording::campaign::Prepared;
use crate::selection::candidates::{Candidate, RIVAL_MARGIN, Screening, penalty};
use crate::selection::effect_test::{EffectTest, OWN_SHARE_MIN};

/// A rival has to do this share of what the effect does: where an effect is weak, chance alone gives
/// others nearly as much gain.
const RESEMBLANCE_MIN: f64 = 0.3;

/// What a first look may be off by, as a share of what the effect explains.
const LOOK_ERROR: f64 = 0.1;

/// An effect with everything that this campaign cannot tell from it.
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
            .candidates_that_gain(&[index], own - margin - LOOK_ERROR * test.gain)
            .into_iter()
            .filter(|it| !it.test.implausible)
            .filter(|it| screening.resemblance(index, &it.term) > RESEMBLANCE_MIN)
            .filter(|it| loss(prepared, fitted, index, &it.term.fixed()) < margin)
            .collect();
        let net = |it: &Candidate<'_>| it.test.gain - penalty(&it.term);
        rivals.sort_by(|a, b| net(b).total_cmp(&net(a)));
        classes.push(Class { rivals });
    }
    classes
}

/// What is lost in -2 log likelihood, penalties included, by a rival in an effect's place.
fn loss<'a>(prepared: &Prepared, fitted: &Fitted<'a>, index: usize, rival: &Term<'a>) -> f64 {
    let mut terms = fitted.terms.clone();
    let own = std::mem::replace(&mut terms[index], rival.clone());
    let with = fit_parameters(prepared, terms, fitted.noise);
    with.chi_squared - fitted.chi_squared + penalty(rival) - penalty(&own)
}
