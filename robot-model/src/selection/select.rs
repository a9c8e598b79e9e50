//! Which effects belong in the model of a campaign? A stepwise search.
//!
//! Forward by the cross-validated gain, with exchanges; then backward, keeping the effects that pass their test
//! given all others. The test of one effect is in [`crate::selection::effect_test`], the candidates beside a
//! fitted model in [`crate::selection::candidates`].

use std::collections::BTreeSet;

use crate::effect::composition::Term;
use crate::effect::definition::Effect;
use crate::estimation::fit::{
    Fitted, Nearness, fit, fit_afresh, fit_roughly, minus_two_log_likelihood,
};
use crate::recording::campaign::Prepared;
use crate::selection::candidates::{Candidate, RIVAL_MARGIN, Screening, is_geometry, penalty};
use crate::selection::chance::{is_chance, without_chance_by_own_noise};
use crate::selection::classes::{Class, classes};
use crate::selection::effect_test::EffectTest;

/// Most effects in a model.
const EFFECTS_MAX: usize = 8;
/// After this many models only removals are tried: real data always offer one more effect.
const MODELS_MAX: usize = 16;
/// Screening lets more pass: an effect that fails its test is removed in the end.
const SCREENING_P_MAX: f64 = 0.03;
/// This many of the effects that fail at first are tested again, with the noise that they leave.
const RECONSIDERED_MAX: usize = 3;

/// The result of the search.
pub(crate) struct Selection<'a> {
    pub fitted: Fitted<'a>,
    /// The test of each effect of the model, given all others.
    pub kept: Vec<EffectTest>,
    /// The test of each other effect, given the model, at the best start of its shapes.
    pub rejected: Vec<Candidate<'a>>,
    /// The candidates beside the final model.
    pub screening: Screening<'a>,
}

impl<'a> Selection<'a> {
    pub(crate) fn new(fitted: Fitted<'a>, screening: Screening<'a>) -> Self {
        let (kept, rejected) = (screening.kept().to_vec(), screening.candidates());
        Self { fitted, kept, rejected, screening }
    }
}

/// The model of a campaign: the most likely one of all models tried in which every effect passes its test.
pub(crate) fn select<'a>(prepared: &Prepared, catalogue: &[&'a dyn Effect]) -> Selection<'a> {
    let mut fitted = fit_roughly(prepared, geometry(catalogue));
    // No model is tried twice, so that the search ends.
    let mut seen = BTreeSet::from([ids(&fitted.terms)]);
    let mut best: Option<(f64, Fitted<'a>)> = None;
    loop {
        let screening = Screening::new(prepared, &fitted, catalogue);
        let removal = removal(prepared, &screening, &fitted);
        if removal.is_none() {
            let cost = cost(prepared, &fitted);
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, fitted.clone()));
            }
        }
        let forward = || {
            exchange(prepared, &screening, &fitted, &seen)
                .or_else(|| addition(prepared, &screening, &fitted, &seen))
        };
        let forward = if seen.len() < MODELS_MAX { forward() } else { None };
        let Some(next) = forward.or(removal) else { break };
        seen.insert(ids(&next));
        fitted = fit(prepared, next, fitted.noise, Nearness::OnTheWay);
    }
    // Every effect of the last model tried passes, so there is a best one.
    let fitted = best.map_or(fitted, |(_, best)| best);
    // The noise must not depend on the path of the search: it is estimated as for a model chosen by hand.
    // With that noise, too, every effect has to pass.
    let mut selection = backward_elimination(prepared, catalogue, fitted.terms);
    while let Some(more) = reconsidered(prepared, catalogue, &selection) {
        selection = more;
    }
    selection
}

/// The selection with radii or track width in the place of effects that these runs cannot tell from them, if they pass.
///
/// Every robot's numbers are a little off, few floors slope; and what three parameters of a floor do no better than a track
/// width, they do on another floor at random. What is in the user's model already stays.
pub(crate) fn geometry_first<'a>(
    prepared: &Prepared,
    catalogue: &[&'a dyn Effect],
    selection: &Selection<'a>,
    in_model: &[&str],
) -> Option<Selection<'a>> {
    let preferred =
        |effect: &dyn Effect| is_geometry(effect) || in_model.contains(&effect.facts().id);
    if selection.fitted.terms.iter().all(|term| preferred(term.effect)) {
        return None;
    }
    let classes = classes(prepared, &selection.fitted, &selection.screening, &selection.kept);
    with_preferred(prepared, catalogue, (selection, &classes), preferred)
}

/// The selection with each effect replaced by a preferred rival that the model lacks, if there is one and all these, and
/// those preferred effects that it had, pass the tests.
pub(crate) fn with_preferred<'a>(
    prepared: &Prepared,
    catalogue: &[&'a dyn Effect],
    (selection, classes): (&Selection<'a>, &[Class<'a>]),
    is_preferred: impl Fn(&dyn Effect) -> bool,
) -> Option<Selection<'a>> {
    let mut terms = selection.fitted.terms.clone();
    let mut changed = false;
    for (index, class) in classes.iter().enumerate() {
        let has = |id: &str| terms.iter().any(|term| term.effect.facts().id == id);
        let replaces = |rival: &&Candidate<'a>| is_preferred(rival.term.effect) && !has(rival.id());
        let rival = class.rivals.iter().find(replaces);
        if let Some(rival) = rival
            && !is_preferred(terms[index].effect)
        {
            terms[index] = rival.term.fixed();
            changed = true;
        }
    }
    if !changed {
        return None;
    }
    let preferred: Vec<Term<'a>> =
        terms.iter().filter(|term| is_preferred(term.effect)).cloned().collect();
    let preferred = ids(&preferred);
    // Effects that were needed only beside what was replaced are dropped. If a preferred one is, what it replaced was right.
    let passing = backward_elimination(prepared, catalogue, terms);
    let passed = ids(&passing.fitted.terms);
    preferred.iter().all(|id| passed.contains(id)).then_some(passing)
}

/// A model of these effects without those that fail their test in it. If one of them is of radii or track width, these
/// are all in it, as far as the runs show them.
pub(crate) fn backward_elimination<'a>(
    prepared: &Prepared,
    catalogue: &[&'a dyn Effect],
    terms: Vec<Term<'a>>,
) -> Selection<'a> {
    let mut fitted = fit_afresh(prepared, with_whole_geometry(terms, catalogue));
    loop {
        let screening = Screening::new(prepared, &fitted, catalogue);
        let removal = removal(prepared, &screening, &fitted)
            .or_else(|| without_chance_by_own_noise(prepared, &screening, &fitted));
        let Some(terms) = removal else {
            match better_without(prepared, catalogue, &screening, &fitted) {
                Some(without) => fitted = without,
                None => return Selection::new(fitted, screening),
            }
            continue;
        };
        fitted = fit_afresh(prepared, terms);
    }
}

/// The model without an effect, if all its other effects pass and it predicts cross-validated tracks better, each
/// model with its own noise.
///
/// An effect changes the noise, the noise the weight of every run, and the weights all other parameters: an effect
/// may pass its test in a model that is worse for it. An effect that makes tracks far better is not tried.
fn better_without<'a>(
    prepared: &Prepared,
    catalogue: &[&'a dyn Effect],
    screening: &Screening<'a>,
    fitted: &Fitted<'a>,
) -> Option<Fitted<'a>> {
    screening.hardly_improves_tracks(prepared).into_iter().find_map(|index| {
        let mut terms = fitted.terms.clone();
        terms.remove(index);
        let without = fit_afresh(prepared, terms);
        let passes = || {
            removal(prepared, &Screening::new(prepared, &without, catalogue), &without).is_none()
        };
        (screening.tracks_are_worse_than(prepared, &without) && passes()).then_some(without)
    })
}

/// A model of these effects, if every one of them passes in it and its tracks are no worse than those of `before`.
fn standing<'a>(
    prepared: &Prepared,
    catalogue: &[&'a dyn Effect],
    terms: Vec<Term<'a>>,
    before: &Fitted<'a>,
) -> Option<Selection<'a>> {
    let fitted = fit_afresh(prepared, terms);
    let screening = Screening::new(prepared, &fitted, catalogue);
    if removal(prepared, &screening, &fitted).is_some()
        || without_chance_by_own_noise(prepared, &screening, &fitted).is_some()
        || screening.tracks_are_worse_than(prepared, before)
    {
        return None;
    }
    Some(Selection::new(fitted, screening))
}

/// Where the search starts: radii and track width free. The residual is then nearer to noise than that of a nominal
/// robot: the noise is not estimated from systematic errors, and no stand-in is tried before the geometry itself.
/// In the end these effects have to pass as all others do.
fn geometry<'a>(catalogue: &[&'a dyn Effect]) -> Vec<Term<'a>> {
    let geometry = catalogue.iter().filter(|effect| is_geometry(**effect));
    geometry.map(|effect| Term::new(*effect, vec![0.0])).collect()
}

/// The terms, with all radii and track width if they have one of these.
///
/// They are measured together: what is left out because these runs hardly show it, the next ones may need.
fn with_whole_geometry<'a>(
    mut terms: Vec<Term<'a>>,
    catalogue: &[&'a dyn Effect],
) -> Vec<Term<'a>> {
    if terms.iter().any(|term| is_geometry(term.effect)) {
        let has = |term: &Term<'a>| {
            terms.iter().any(|other| other.effect.facts().id == term.effect.facts().id)
        };
        let missing: Vec<Term<'a>> =
            geometry(catalogue).into_iter().filter(|term| !has(term)).collect();
        terms.extend(missing);
    }
    terms
}

/// -2 log likelihood with the fitted noise, plus the penalty: the criterion between models that pass.
fn cost(prepared: &Prepared, fitted: &Fitted<'_>) -> f64 {
    let runs: Vec<_> = prepared.runs.iter().collect();
    minus_two_log_likelihood(&runs, &fitted.terms, &fitted.noise)
        + fitted.terms.iter().map(penalty).sum::<f64>()
}

fn ids(terms: &[Term<'_>]) -> Vec<String> {
    let mut ids: Vec<String> = terms.iter().map(|term| term.effect.facts().id.to_owned()).collect();
    ids.sort();
    ids
}

/// The model with one or two effects exchanged for a single one that explains as much.
fn exchange<'a>(
    prepared: &Prepared,
    screening: &Screening<'a>,
    fitted: &Fitted<'a>,
    seen: &BTreeSet<Vec<String>>,
) -> Option<Vec<Term<'a>>> {
    let count = fitted.terms.len();
    let singles = (0..count).map(|i| vec![i]);
    let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| vec![i, j]));
    let whole = screening.cost_without(&[]);
    // Where runs scatter more than their noise, sigmas are wider.
    let kept = screening.kept();
    for left_out in singles.chain(pairs) {
        let without = screening.cost_without(&left_out);
        // One for one only where the data can tell them apart; one for two by parsimony.
        let wanted = match left_out[..] {
            [index] => whole - RIVAL_MARGIN * kept[index].dispersion,
            _ => whole,
        };
        let better = screening
            .candidates_that_gain(&left_out, without - wanted)
            .into_iter()
            .filter(|candidate| candidate.test.passes_cross_validation())
            .filter(|candidate| !seen.contains(&ids(&exchanged(fitted, &left_out, candidate))))
            // If the data want these effects beside the candidate as well, that is an addition, no exchange.
            .filter(|candidate| {
                let both = screening.cost(&[], Some(&candidate.term));
                screening.cost(&left_out, Some(&candidate.term)) - both < RIVAL_MARGIN
            })
            .max_by(|a, b| net_gain(a).total_cmp(&net_gain(b)));
        if let Some(candidate) = better
            && !screening.tracks_get_worse(prepared, &left_out, &candidate.term)
        {
            return Some(exchanged(fitted, &left_out, &candidate));
        }
    }
    None
}

/// The model's terms with a candidate in place of some.
fn exchanged<'a>(
    fitted: &Fitted<'a>,
    left_out: &[usize],
    candidate: &Candidate<'a>,
) -> Vec<Term<'a>> {
    let kept = fitted.terms.iter().enumerate().filter(|(i, _)| !left_out.contains(i));
    kept.map(|(_, term)| term.clone()).chain([candidate.term.fixed()]).collect()
}

/// Gain less the penalty of the parameters.
fn net_gain(candidate: &Candidate<'_>) -> f64 {
    candidate.test.gain - penalty(&candidate.term)
}

/// The model with one candidate added: the one with the largest cross-validated gain; of near equals, the simplest.
fn addition<'a>(
    prepared: &Prepared,
    screening: &Screening<'a>,
    fitted: &Fitted<'a>,
    seen: &BTreeSet<Vec<String>>,
) -> Option<Vec<Term<'a>>> {
    additions(screening, fitted)
        .into_iter()
        .filter(|candidate| !seen.contains(&ids(&exchanged(fitted, &[], candidate))))
        .find(|candidate| !screening.tracks_get_worse(prepared, &[], &candidate.term))
        .map(|candidate| exchanged(fitted, &[], &candidate))
}

/// The candidates that pass the screening, by falling cross-validated gain; of near equals, the simplest first.
fn additions<'a>(screening: &Screening<'a>, fitted: &Fitted<'a>) -> Vec<Candidate<'a>> {
    if fitted.terms.len() == EFFECTS_MAX {
        return Vec::new();
    }
    let mut passing: Vec<Candidate<'a>> = screening
        .candidates()
        .into_iter()
        .filter(|candidate| {
            candidate.test.p_value < SCREENING_P_MAX && candidate.test.passes_cross_validation()
        })
        .collect();
    // Where runs disagree about an effect, its gain counts for less.
    let merit = |candidate: &Candidate<'_>| {
        (candidate.test.cross_validated_gain - penalty(&candidate.term)) / candidate.test.dispersion
    };
    let mut sorted = Vec::new();
    while !passing.is_empty() {
        let most = passing.iter().map(merit).fold(f64::NEG_INFINITY, f64::max);
        // Of those that the data cannot tell from the best, the one of fewest parameters, listed first.
        let near = (0..passing.len()).filter(|i| merit(&passing[*i]) > most - RIVAL_MARGIN);
        let Some(chosen) = near.min_by_key(|i| passing[*i].term.values.len()) else { break };
        sorted.push(passing.remove(chosen));
    }
    sorted
}

/// The model with one more effect, which passes once the noise is estimated together with it.
///
/// A missing effect is part of the estimated noise, so that a weak effect hides itself.
fn reconsidered<'a>(
    prepared: &Prepared,
    catalogue: &[&'a dyn Effect],
    Selection { fitted, screening, .. }: &Selection<'a>,
) -> Option<Selection<'a>> {
    additions(screening, fitted)
        .iter()
        .filter(|candidate| !screening.tracks_get_worse(prepared, &[], &candidate.term))
        .take(RECONSIDERED_MAX)
        .find_map(|candidate| {
            standing(prepared, catalogue, exchanged(fitted, &[], candidate), fitted)
        })
}

/// Whether each effect of the model passes its test, given all others.
///
/// Kinds of runs disagree about radii and track width whenever anything else is missing, so this disagreement is no
/// evidence against them. Where one of these passes, the others stay with it, if the runs show them.
fn passes_given_the_others(
    prepared: &Prepared,
    screening: &Screening<'_>,
    fitted: &Fitted<'_>,
) -> Vec<bool> {
    let kept = screening.kept();
    let (spoils, unsettled) = (screening.spoils_tracks(prepared), screening.is_unsettled());
    let shown = screening.is_shown();
    let of_geometry: Vec<bool> = fitted.terms.iter().map(|term| is_geometry(term.effect)).collect();
    let passes: Vec<bool> = (0..kept.len())
        .map(|i| {
            let test = &kept[i];
            let predicts = if of_geometry[i] {
                test.predicts_better()
            } else {
                test.passes_cross_validation()
            };
            predicts
                && !is_chance(test, screening.asked(), kept.len())
                && !spoils[i]
                && !unsettled[i]
        })
        .collect();
    let geometry_found = (0..kept.len()).any(|i| of_geometry[i] && passes[i]);
    let stays = |i: usize| of_geometry[i] && geometry_found && shown[i] && !unsettled[i];
    (0..kept.len()).map(|i| passes[i] || stays(i)).collect()
}

/// The model without the weakest of the effects that do not pass in it; `None` if all do.
fn removal<'a>(
    prepared: &Prepared,
    screening: &Screening<'a>,
    fitted: &Fitted<'a>,
) -> Option<Vec<Term<'a>>> {
    let kept = screening.kept();
    let passes = passes_given_the_others(prepared, screening, fitted);
    let worst = (0..kept.len())
        .filter(|i| !passes[*i])
        .min_by(|a, b| kept[*a].cross_validated_gain.total_cmp(&kept[*b].cross_validated_gain))?;
    let mut terms = fitted.terms.clone();
    terms.remove(worst);
    Some(terms)
}

#[cfg(test)]
mod tests;
