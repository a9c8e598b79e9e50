//! Chooses the effects of a model: forward by what is gained on runs held out, with exchanges, then
//! back, keeping what stands when everything else is known. How an effect is judged is in
//! [`crate::selection::effect_test`].

use std::collections::BTreeSet;

use crate::effect::composition::Term;
use crate::effect::definition::Effect;
use crate::estimation::fit::{Fitted, fit, fit_afresh, fit_roughly, minus_two_log_likelihood};
use crate::recording::campaign::Prepared;
use crate::selection::candidates::{Candidate, RIVAL_MARGIN, Screening, is_geometry, penalty};
use crate::selection::effect_test::EffectTest;

/// Most effects that are looked for.
const EFFECTS_MAX: usize = 8;
/// Most models that are tried before nothing but removals are: real data always offer one more.
const MODELS_MAX: usize = 16;
/// By chance alone the likelihood asks for an effect in a perfect robot this often; runs held out refuse most of
/// these, so that fewer than 5 % get one.
const FALSE_ALARM: f64 = 0.20;
/// Beside another effect it takes more: what an equation does not say of its own effect looks like one more.
const FALSE_ALARM_BESIDE: f64 = 0.10;
/// A first look lets more pass: what does not stand is removed in the end.
const FIRST_LOOK_P: f64 = 0.03;
/// Of those that do not stand at first, so many are looked at with the noise that they leave.
const RECONSIDERED_MAX: usize = 3;
/// What the search came to.
pub(crate) struct Selection<'a> {
    pub fitted: Fitted<'a>,
    /// For each effect of the model, what speaks for it, given all others.
    pub kept: Vec<EffectTest>,
    /// All others, each given the model, best start of its shapes.
    pub rejected: Vec<Candidate<'a>>,
    /// The look from the final model.
    pub screening: Screening<'a>,
}

impl<'a> Selection<'a> {
    fn new(fitted: Fitted<'a>, screening: Screening<'a>) -> Self {
        let (kept, rejected) = (screening.kept(), screening.candidates(&[]));
        Self { fitted, kept, rejected, screening }
    }
}

/// The model of a campaign: of all models tried in which every effect stands, the most likely one.
pub(crate) fn select<'a>(prepared: &Prepared, catalogue: &[&'a dyn Effect]) -> Selection<'a> {
    let mut fitted = fit_roughly(prepared, geometry(catalogue));
    // What was tried before is not gone to again, so that the search ends.
    let mut seen = BTreeSet::from([ids(&fitted.terms)]);
    let mut best: Option<(f64, Fitted<'a>)> = None;
    loop {
        let screening = Screening::new(prepared, &fitted, catalogue);
        let falls = removal(prepared, &screening, &fitted);
        if falls.is_none() {
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
        let Some(next) = forward.or(falls) else { break };
        seen.insert(ids(&next));
        fitted = fit(prepared, next, fitted.noise);
    }
    // The last model tried stands, so there is a best one.
    let fitted = best.map_or(fitted, |(_, it)| it);
    // Its noise is not to depend on the way that led to it: it is learnt as for a model chosen by hand.
    // And with that noise, too, every effect has to stand.
    let mut selection = settled(prepared, catalogue, fitted.terms);
    while let Some(it) = reconsidered(prepared, catalogue, &selection) {
        selection = it;
    }
    selection
}

/// What is left of a model of these effects when all that does not stand in it is gone.
pub(crate) fn settled<'a>(
    prepared: &Prepared,
    catalogue: &[&'a dyn Effect],
    terms: Vec<Term<'a>>,
) -> Selection<'a> {
    let mut fitted = fit_afresh(prepared, terms);
    loop {
        let screening = Screening::new(prepared, &fitted, catalogue);
        let Some(terms) = removal(prepared, &screening, &fitted) else {
            match better_without(prepared, catalogue, &screening, &fitted) {
                Some(without) => fitted = without,
                None => return Selection::new(fitted, screening),
            }
            continue;
        };
        fitted = fit_afresh(prepared, terms);
    }
}

/// The model without an effect, if all else stands in it and tracks of runs held out are predicted better by it with
/// the noise that is its own.
///
/// What an effect does to the noise changes what every run weighs, and with it all other parameters: it may look
/// good in a model that is worse for it. Where an effect makes tracks far better there is no need to ask.
fn better_without<'a>(
    prepared: &Prepared,
    catalogue: &[&'a dyn Effect],
    screening: &Screening<'a>,
    fitted: &Fitted<'a>,
) -> Option<Fitted<'a>> {
    screening.hardly_better_tracks(prepared).into_iter().find_map(|index| {
        let mut terms = fitted.terms.clone();
        terms.remove(index);
        let without = fit_afresh(prepared, terms);
        let stands = || {
            removal(prepared, &Screening::new(prepared, &without, catalogue), &without).is_none()
        };
        (screening.tracks_are_worse_than(prepared, &without) && stands()).then_some(without)
    })
}

/// A model of these effects, if every one of them stands in it, and tracks are no worse than `before`.
fn standing<'a>(
    prepared: &Prepared,
    catalogue: &[&'a dyn Effect],
    terms: Vec<Term<'a>>,
    before: &Fitted<'a>,
) -> Option<Selection<'a>> {
    let fitted = fit_afresh(prepared, terms);
    let screening = Screening::new(prepared, &fitted, catalogue);
    if removal(prepared, &screening, &fitted).is_some()
        || screening.tracks_are_worse_than(prepared, before)
    {
        return None;
    }
    Some(Selection::new(fitted, screening))
}

/// Where the search starts: radii and track width free. What is left over is then nearer to noise than
/// what a nominal robot leaves, so that the noise is not learnt from the errors that are looked for, and
/// no stand-in gets a hearing before they had theirs. They have to stand in the end as all others do.
fn geometry<'a>(catalogue: &[&'a dyn Effect]) -> Vec<Term<'a>> {
    let wanted = catalogue.iter().filter(|it| is_geometry(**it));
    wanted.map(|effect| Term::new(*effect, vec![0.0])).collect()
}

/// -2 log likelihood with the noise as fitted, and the penalty: what standing models are compared by.
fn cost(prepared: &Prepared, fitted: &Fitted<'_>) -> f64 {
    let runs: Vec<_> = prepared.runs.iter().collect();
    minus_two_log_likelihood(&runs, &fitted.terms, &fitted.noise)
        + fitted.terms.iter().map(penalty).sum::<f64>()
}

fn ids(terms: &[Term<'_>]) -> Vec<String> {
    let mut ids: Vec<String> = terms.iter().map(|it| it.effect.facts().id.to_owned()).collect();
    ids.sort();
    ids
}

/// The model with one effect, or two, exchanged for a single one that explains as much.
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
            .filter(|it| it.test.passes_cross_validation())
            .filter(|it| !seen.contains(&ids(&exchanged(fitted, &left_out, it))))
            // What is wanted beside the candidate as well is not exchanged for it: that is an addition.
            .filter(|it| {
                let both = screening.cost(&[], Some(&it.term));
                screening.cost(&left_out, Some(&it.term)) - both < RIVAL_MARGIN
            })
            .max_by(|a, b| net_gain(a).total_cmp(&net_gain(b)));
        if let Some(it) = better
            && !screening.tracks_get_worse(prepared, &left_out, &it.term)
        {
            return Some(exchanged(fitted, &left_out, &it));
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
    kept.map(|(_, it)| it.clone()).chain([candidate.term.fixed()]).collect()
}

/// Gain less the penalty of the parameters.
fn net_gain(it: &Candidate<'_>) -> f64 {
    it.test.gain - penalty(&it.term)
}

/// The model with the candidate added that gains most on held-out runs; of near equals, the simplest.
fn addition<'a>(
    prepared: &Prepared,
    screening: &Screening<'a>,
    fitted: &Fitted<'a>,
    seen: &BTreeSet<Vec<String>>,
) -> Option<Vec<Term<'a>>> {
    additions(screening, fitted)
        .into_iter()
        .filter(|it| !seen.contains(&ids(&exchanged(fitted, &[], it))))
        .find(|it| !screening.tracks_get_worse(prepared, &[], &it.term))
        .map(|it| exchanged(fitted, &[], &it))
}

/// The candidates that a first look lets pass, those that gain most on held-out runs first; of near equals,
/// the simplest first.
fn additions<'a>(screening: &Screening<'a>, fitted: &Fitted<'a>) -> Vec<Candidate<'a>> {
    if fitted.terms.len() == EFFECTS_MAX {
        return Vec::new();
    }
    let mut passing: Vec<Candidate<'a>> = screening
        .candidates(&[])
        .into_iter()
        .filter(|it| it.test.p_value < FIRST_LOOK_P && it.test.passes_cross_validation())
        .collect();
    // Where runs disagree about an effect, its gain counts for less.
    let merit = |it: &Candidate<'_>| {
        (it.test.cross_validated_gain - penalty(&it.term)) / it.test.dispersion
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

/// The model with one effect more that stands once the noise is learnt with it, and did not in passing.
///
/// What is missing is part of the noise for as long as it is missing, so that a weak effect hides itself.
fn reconsidered<'a>(
    prepared: &Prepared,
    catalogue: &[&'a dyn Effect],
    Selection { fitted, screening, .. }: &Selection<'a>,
) -> Option<Selection<'a>> {
    additions(screening, fitted)
        .iter()
        .filter(|it| !screening.tracks_get_worse(prepared, &[], &it.term))
        .take(RECONSIDERED_MAX)
        .find_map(|it| standing(prepared, catalogue, exchanged(fitted, &[], it), fitted))
}

/// Whether chance gives as much as this judgement says in a model of so many effects, this one counted, where
/// so many are asked about.
pub(crate) fn is_chance(it: &EffectTest, asked: usize, effects: usize) -> bool {
    // Bonferroni: one is asked about all that might be there.
    it.p_value * asked as f64 > if effects > 1 { FALSE_ALARM_BESIDE } else { FALSE_ALARM }
}

/// The model without the effect that stands least, given all others.
///
/// Radii and track width are what kinds of runs disagree about whenever anything else is missing, so
/// that disagreement is no evidence against them.
fn removal<'a>(
    prepared: &Prepared,
    screening: &Screening<'a>,
    fitted: &Fitted<'a>,
) -> Option<Vec<Term<'a>>> {
    let kept = screening.kept();
    let (spoils, unsettled) = (screening.spoils_tracks(prepared), screening.is_unsettled());
    let worst = (0..kept.len())
        .filter(|i| {
            let it = &kept[*i];
            let is_geometry = is_geometry(fitted.terms[*i].effect);
            is_chance(it, screening.asked(), kept.len())
                || spoils[*i]
                || unsettled[*i]
                || !(if is_geometry { it.is_sound() } else { it.passes_cross_validation() })
        })
        .min_by(|a, b| kept[*a].cross_validated_gain.total_cmp(&kept[*b].cross_validated_gain))?;
    let mut terms = fitted.terms.clone();
    terms.remove(worst);
    Some(terms)
}
