//! What the data cannot tell apart: for each effect of a model, the rivals that would explain as much.
//!
//! An effect is taken out and each other effect put in its place, everything fitted anew. If that loses
//! less than three sigma, 9 in -2 log likelihood, the rival is as good an answer, and it is named in one
//! breath with the effect. The data decide: no list of confounds is kept.

use crate::judge::Judgement;
use crate::look::{Candidate, Look, penalty};
use crate::select::RIVAL_MARGIN;

/// A rival has to do this share of what the effect does: where an effect is weak, chance alone gives
/// others nearly as much gain.
const RESEMBLANCE_MIN: f64 = 0.3;

/// An effect with everything that this campaign cannot tell from it.
#[derive(Clone, Debug)]
pub(crate) struct Class<'a> {
    /// Rivals, best first, the chosen effect not included.
    pub rivals: Vec<Candidate<'a>>,
}

/// The class of each effect of the model.
pub(crate) fn classes<'a>(look: &Look<'a>, kept: &[Judgement]) -> Vec<Class<'a>> {
    let mut classes = Vec::new();
    for (index, judgement) in kept.iter().enumerate() {
        // Where runs scatter more than their noise, sigmas are wider.
        let margin = RIVAL_MARGIN * judgement.dispersion;
        let own = judgement.gain - penalty(look.term(index));
        let mut rivals: Vec<Candidate<'a>> = look
            .candidates_that_gain(&[index], own - margin)
            .into_iter()
            .filter(|it| !it.judgement.implausible)
            .filter(|it| look.resemblance(index, &it.term) > RESEMBLANCE_MIN)
            .collect();
        let net = |it: &Candidate<'_>| it.judgement.gain - penalty(&it.term);
        rivals.sort_by(|a, b| net(b).total_cmp(&net(a)));
        classes.push(Class { rivals });
    }
    classes
}
