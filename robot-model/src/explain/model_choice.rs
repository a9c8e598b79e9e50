//! The choice of effects, made by a noise estimate that no missing effect inflates, and held against simpler
//! models.

use crate::effect::definition::Effect;
use crate::estimation::errors::lower;
use crate::estimation::fit::Fitted;
use crate::explain::alternative_fit::{AlternativeFit, alternative_fit};
use crate::explain::model_errors::errors;
use crate::recording::campaign::Prepared;
use crate::recording::odometry_noise::OdometryNoise;
use crate::residuals::flexible_model::{Flexible, flexible, reaching_further};
use crate::selection::candidates::{Screening, is_geometry};
use crate::selection::chance::is_chance;
use crate::selection::classes::{Class, classes};
use crate::selection::effect_test::EffectTest;
use crate::selection::select::{Selection, geometry_first, select, with_preferred};

/// The effects chosen for a campaign.
pub(crate) struct Choice<'a> {
    /// The campaign, with the noise that the choice was made by.
    pub prepared: Prepared,
    /// The effects, and the tests of all.
    pub selection: Selection<'a>,
    /// What cannot be told from each effect.
    pub classes: Vec<Class<'a>>,
    /// The noise that weighs the runs for values and errors.
    pub weights: OdometryNoise,
    /// The noise of the search that learns it from residuals, whichever search was taken.
    pub first_noise: OdometryNoise,
    /// What a flexible model reaches beside them.
    pub flexible: Flexible,
    /// Radii and track width that are in the model only beside others of them, by their place in it.
    pub along: Vec<usize>,
    /// The effects as selected, before any alternative fit.
    pub selected: Fitted<'a>,
    /// What predicts better, if anything does.
    pub alternative: Option<AlternativeFit<'a>>,
}

/// Chooses effects; those of `in_model` are preferred in their classes.
pub(crate) fn choose<'a>(
    prepared: Prepared,
    catalogue: &[&'a dyn Effect],
    in_model: &[&str],
) -> Choice<'a> {
    let selection = select(&prepared, catalogue);
    let mut first_noise = selection.fitted.noise;
    let (prepared, mut selection, flexible) = beyond_noise(prepared, selection, catalogue);
    let mut flexible = reaching_further(flexible, &prepared, &selection.fitted, catalogue);
    if let Some(replaced) = geometry_first(&prepared, catalogue, &selection, in_model) {
        let Fitted { terms, noise, .. } = &replaced.fitted;
        flexible.model = errors(&prepared, noise, terms).cross_validated;
        if prepared.noise.is_none() {
            first_noise = *noise;
        }
        selection = replaced;
    }
    let alternative = alternative_fit(&prepared, &selection.fitted, catalogue);
    let selected = selection.fitted.clone();
    if let Some(alternative) = &alternative {
        // Tests and classes go by the estimated noise; values and errors by the better weights.
        let fitted = Fitted { noise: selected.noise, ..alternative.fitted.clone() };
        let screening = Screening::new(&prepared, &fitted, catalogue);
        selection = Selection::new(fitted, screening);
    }
    let mut classes = classes_of(&prepared, &selection);
    if let Some(replaced) = with_known(&prepared, catalogue, (&selection, &classes), in_model) {
        selection = replaced;
        classes = classes_of(&prepared, &selection);
    }
    let weights =
        alternative.as_ref().map_or(selection.fitted.noise, |alternative| alternative.fitted.noise);
    let along = (0..selection.kept.len()).filter(|index| !is_found(&selection, *index)).collect();
    Choice {
        prepared,
        selection,
        classes,
        weights,
        first_noise,
        flexible,
        along,
        selected,
        alternative,
    }
}

/// Less noise than this share of what was learnt is worth another search.
const LESS_NOISE: f64 = 0.9;

/// What is left of a model, relative to the reachable error, that must not go without a word.
pub(super) const EXCESS_MAX: f64 = 1.2;

/// This selection, or one by a noise estimate that no missing effect inflates; and what a flexible model reaches beside
/// it.
///
/// Noise is learnt from residuals, so what no effect explains passes for noise and hides effects that are there. The
/// flexible model takes up whatever repeats; if it leaves less noise, the search is made again with that. The outcome
/// stands if it comes near the reachable error: with little noise, something that the catalogue lacks is imitated by
/// many effects. What either flexible model reaches is reachable: beside imitations the second one may find nothing more.
fn beyond_noise<'a>(
    prepared: Prepared,
    selection: Selection<'a>,
    catalogue: &[&'a dyn Effect],
) -> (Prepared, Selection<'a>, Flexible) {
    let first = flexible(&prepared, &selection.fitted, catalogue);
    if first.excess(prepared.robot.track_width_m) < 1.0 / LESS_NOISE {
        return (prepared, selection, first);
    }
    let honest = Prepared { noise: Some(first.noise), ..prepared.clone() };
    let again = select(&honest, catalogue);
    let track_width_m = prepared.robot.track_width_m;
    let (first, second) =
        both_reach(first, flexible(&honest, &again.fitted, catalogue), track_width_m);
    if second.excess(track_width_m) < EXCESS_MAX.min(first.excess(track_width_m)) {
        (honest, again, second)
    } else {
        (prepared, selection, first)
    }
}

/// Two flexible models, each with the lower of the errors that they reach.
fn both_reach(first: Flexible, second: Flexible, track_width_m: f64) -> (Flexible, Flexible) {
    let reachable = lower(&first.reachable, &second.reachable, track_width_m);
    (Flexible { reachable, ..first }, Flexible { reachable, ..second })
}

/// What cannot be told from each effect. An effect that is in the model only beside others of radii and track width is
/// not found, so nothing can be found in its place.
fn classes_of<'a>(prepared: &Prepared, selection: &Selection<'a>) -> Vec<Class<'a>> {
    let mut classes = classes(prepared, &selection.fitted, &selection.screening, &selection.kept);
    for (index, class) in classes.iter_mut().enumerate() {
        if !is_found(selection, index) {
            class.rivals.clear();
        }
    }
    classes
}

/// Whether an effect of the model is there by its own test. Only radii and track width may be in it without.
fn is_found(selection: &Selection<'_>, index: usize) -> bool {
    let Selection { fitted, kept, screening, .. } = selection;
    let test = &kept[index];
    !is_geometry(fitted.terms[index].effect)
        || (test.predicts_better() && !is_chance(test, screening.asked(), kept.len()))
}

/// The selection with each effect replaced by a rival that the model has already, if there is one and all
/// of these pass the tests. Otherwise a known effect would be named as its rival, and the values of all others
/// would jump from one campaign to the next.
fn with_known<'a>(
    prepared: &Prepared,
    catalogue: &[&'a dyn Effect],
    selection: (&Selection<'a>, &[Class<'a>]),
    in_model: &[&str],
) -> Option<Selection<'a>> {
    let is_known = |effect: &dyn Effect| in_model.contains(&effect.facts().id);
    with_preferred(prepared, catalogue, selection, is_known)
}

/// The effects of the model: each next one brings tracks of other runs nearest, given those before. Where none of those
/// left does, as for effects of a sensor, the likelihood decides.
pub(super) fn by_evidence(
    prepared: &Prepared,
    screening: &Screening<'_>,
    kept: &[EffectTest],
) -> Vec<usize> {
    let mut left: Vec<usize> = (0..kept.len()).collect();
    let mut order = Vec::new();
    let mut before_m2 = screening.displacement_m2(prepared, &left);
    while !left.is_empty() {
        let without = |index: usize| -> Vec<usize> {
            left.iter().copied().filter(|other| *other != index).collect()
        };
        let each = left.iter().map(|index| screening.displacement_m2(prepared, &without(*index)));
        let displacements_m2: Vec<f64> = each.collect();
        let least = |values: &[f64]| {
            (0..values.len())
                .min_by(|a, b| values[*a].total_cmp(&values[*b]))
                .expect("some are left")
        };
        let mut best = least(&displacements_m2);
        if displacements_m2[best] > (1.0 - NEARER) * before_m2 {
            let costs: Vec<f64> =
                left.iter().map(|index| screening.cost_without(&without(*index))).collect();
            best = least(&costs);
        }
        before_m2 = displacements_m2[best];
        order.push(left.remove(best));
    }
    order
}

/// Tracks are nearer if their squared displacements fall by this share.
const NEARER: f64 = 1e-3;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimation::errors::Errors;

    #[test]
    fn a_second_model_is_held_against_what_the_first_flexible_model_reached() {
        let of = |mm: f64| Errors { position_rms_m: 1e-3 * mm, ..Errors::default() };
        let flexible = |model_mm: f64, reachable_mm: f64| Flexible {
            reachable: of(reachable_mm),
            model: of(model_mm),
            noise: OdometryNoise::TYPICAL,
            depends_on: Vec::new(),
        };
        // Beside many imitations a flexible model finds nothing more: that is no proof that nothing is left.
        let (first, second) = both_reach(flexible(4.0, 1.1), flexible(3.7, 3.7), 0.3);
        assert!(second.excess(0.3) > EXCESS_MAX, "{second:?}");
        assert_eq!(first.reachable, of(1.1));
        // Nor does the first one know better than the second.
        let (first, _) = both_reach(flexible(4.0, 2.0), flexible(3.0, 1.1), 0.3);
        assert_eq!(first.reachable, of(1.1));
    }
}
