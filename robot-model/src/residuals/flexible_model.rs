//! What could any model reach on these runs? The reachable error, which does not depend on the catalogue.
//!
//! A flexible model is the model of known effects with basis functions of everything that was recorded
//! ([`super::basis_functions`], [`super::auxiliary_effects`], [`super::wheel_rates`], places on the floor), and with the
//! effects of the catalogue. It takes up what predicts runs that it was not fitted to, group by group
//! ([`super::group_search`]).
//!
//! What repeats is then in the model and not in the noise, so the noise is estimated anew with the groups in place, and
//! with less noise more is seen: a few rounds. Nothing that the flexible model takes up is an explanation. Its
//! cross-validated error is the reachable error: what a model of effects leaves above it is physics that is missing.

use crate::effect::composition::Term;
use crate::effect::definition::Effect;
use crate::estimation::errors::{Errors, displacement_m};
use crate::estimation::fit::Fitted;
use crate::recording::campaign::Prepared;
use crate::recording::odometry_noise::OdometryNoise;
use crate::residuals::auxiliary_effects::{AFTER_A_TURN, AUXILIARY_EFFECTS};
use crate::residuals::basis_functions::FUNCTIONS;
use crate::residuals::campaign_times::campaign_times;
use crate::residuals::floor_location::{best_places, visited};
use crate::residuals::group_search::{FlexibleFit, GroupSearch};
use crate::residuals::place_waves::{PlaceWave, strongest};
use crate::residuals::regressor::Regressor;
use crate::residuals::wheel_rates::wheel_rates;
use crate::residuals::whiteness::persisting;

/// The groups are chosen from at most this many poses of a run: their shapes are wide.
const POSES_MAX: usize = 200;

/// A flexible model of a campaign.
#[derive(Clone, Debug)]
pub(crate) struct Flexible {
    /// Its cross-validated errors.
    pub reachable: Errors,
    /// Those of the model that it began with.
    pub model: Errors,
    /// The noise that it leaves.
    pub noise: OdometryNoise,
    /// What its groups are functions of, the most important one first; `None` is an effect of the catalogue.
    pub depends_on: Vec<Option<Regressor>>,
}

impl Flexible {
    /// What the best fit reaches beside the model, with groups of this pool.
    fn new(
        model: &FlexibleFit<'_>,
        best: &FlexibleFit<'_>,
        pool: &[(Option<Regressor>, Term<'_>)],
    ) -> Self {
        Self {
            reachable: best.errors,
            model: model.errors,
            noise: best.noise,
            depends_on: best.taken.iter().map(|index| pool[*index].0).collect(),
        }
    }

    /// By how many times the model's errors exceed the reachable error, as displacements of the wheels.
    pub fn excess(&self, track_width_m: f64) -> f64 {
        let of = |errors: &Errors| displacement_m(errors, track_width_m);
        let reachable = of(&self.reachable);
        if reachable > 0.0 { of(&self.model) / reachable } else { 1.0 }
    }
}

/// Fits a flexible model that begins with a fitted one.
pub(crate) fn flexible(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    catalogue: &[&dyn Effect],
) -> Flexible {
    let thinned = thinned(prepared);
    let patches = visited(prepared);
    let mut pool = pool(prepared, fitted, catalogue);
    pool.extend(of_regressor(Regressor::Place, &patches));
    let search = GroupSearch::new((prepared, &thinned), false, &pool);
    let model = search.evaluated(fitted.terms.clone(), Vec::new(), fitted.noise);
    let mut begun = search.with_groups_worth_adding(&model);
    if !search.is_lower(&begun, &model) {
        begun = model.clone();
    }
    Flexible::new(&model, &search.with_falls(begun), &pool)
}

/// The flexible model, or one with more functions and a wider search, if that reaches less.
///
/// The noise of the wider one weighs no choice: the more functions, the more of the noise of few runs they take up, and a
/// choice that goes by less noise names what is not there.
pub(crate) fn reaching_further(
    first: Flexible,
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    catalogue: &[&dyn Effect],
) -> Flexible {
    let thinned = thinned(prepared);
    let mut patches = visited(prepared);
    patches.extend(best_places(&thinned, fitted));
    let rates = wheel_rates(&prepared.excitation);
    let mut pool = pool(prepared, fitted, catalogue);
    pool.extend(of_regressor(Regressor::Place, &patches));
    pool.extend(of_regressor(Regressor::WheelSpeed, &rates));
    pool.extend(of_regressor(Regressor::TurnRate, &AFTER_A_TURN));
    let further = searched((prepared, &thinned), fitted, &pool, first);
    // Beside more functions a search may miss what it found without them: these have one of their own.
    let waves: Vec<PlaceWave> =
        strongest(prepared, fitted).into_iter().map(|(wave, _)| wave).collect();
    if waves.is_empty() && persisting(prepared, fitted).is_none() {
        return further;
    }
    let times = campaign_times(prepared);
    pool.extend(of_regressor(Regressor::Place, &waves));
    pool.extend(of_regressor(Regressor::TimeInCampaign, &times));
    searched((prepared, &thinned), fitted, &pool, further)
}

/// A flexible model, or what groups of this pool reach, if that is less.
fn searched<'a>(
    (prepared, thinned): (&Prepared, &Prepared),
    fitted: &Fitted<'a>,
    pool: &[(Option<Regressor>, Term<'a>)],
    first: Flexible,
) -> Flexible {
    let search = GroupSearch::new((prepared, thinned), true, pool);
    let model = search.evaluated(fitted.terms.clone(), Vec::new(), fitted.noise);
    // What gains most likelihood may keep out what lowers displacements most: both begin once.
    let begun = search.with_groups_worth_adding(&model);
    let mut best = search.with_falls(begun.clone());
    if !begun.taken.is_empty() {
        let other = search.with_falls(model.clone());
        if search.is_lower(&other, &best) {
            best = other;
        }
    }
    let track_width_m = prepared.robot.track_width_m;
    let of = |errors: &Errors| displacement_m(errors, track_width_m);
    if of(&best.errors) < of(&first.reachable) {
        Flexible { noise: first.noise, ..Flexible::new(&model, &best, pool) }
    } else {
        first
    }
}

fn zero(effect: &dyn Effect) -> Term<'_> {
    Term::new(effect, vec![0.0; effect.facts().parameters.len()])
}

/// All groups but places and wheel rates.
fn pool<'a>(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    catalogue: &[&'a dyn Effect],
) -> Vec<(Option<Regressor>, Term<'a>)> {
    let in_model = |id: &str| fitted.terms.iter().any(|term| term.effect.facts().id == id);
    let known = catalogue.iter().filter(|effect| !in_model(effect.facts().id));
    let known = known.flat_map(|effect| {
        let starts = effect.starts(&prepared.excitation).into_iter();
        starts.map(|values| (None, Term::new(*effect, values)))
    });
    let functions = FUNCTIONS.iter().chain(AUXILIARY_EFFECTS);
    known.chain(functions.map(|one| (Some(one.regressor), zero(one)))).collect()
}

/// Groups that are functions of this.
fn of_regressor<E: Effect>(
    regressor: Regressor,
    effects: &[E],
) -> impl Iterator<Item = (Option<Regressor>, Term<'_>)> {
    effects.iter().map(move |effect| (Some(regressor), zero(effect)))
}

/// The campaign with fewer poses.
fn thinned(prepared: &Prepared) -> Prepared {
    let mut thinned = prepared.clone();
    for run in &mut thinned.runs {
        let poses = &mut run.recording.measured_poses;
        let every = poses.len().div_ceil(POSES_MAX).max(1);
        let last = poses.len().saturating_sub(1);
        let mut index = 0;
        poses.retain(|_| {
            let keep = index % every == 0 || index == last;
            index += 1;
            keep
        });
    }
    thinned
}

#[cfg(test)]
mod tests;
