//! What could any model reach on these runs? The reachable error, which does not depend on the catalogue.
//!
//! A flexible model is the model of known effects with basis functions of everything that was recorded
//! ([`super::basis_functions`], [`super::auxiliary_effects`], places on the floor), and with the effects of the
//! catalogue. It takes up what predicts runs that it was not fitted to, group by group:
//!
//! ```text
//! gain of a group = sum over runs of chi^2(model) - chi^2(model + group), both fitted to all other runs     (1)
//! ```
//!
//! Where such groups together predict tracks worse, groups are chosen by displacements of runs left out (2).
//!
//! What repeats is then in the model and not in the noise, so the noise is estimated anew with the groups in place, and
//! with less noise more is seen: a few rounds. Nothing that the flexible model takes up is an explanation. Its
//! cross-validated error is the reachable error: what a model of effects leaves above it is physics that is missing.

use crate::effect::composition::{PlacedTerm, Term};
use crate::effect::definition::Effect;
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::errors::{Errors, TrackErrors, cross_validated, tracks};
use crate::estimation::fit::{Fitted, fit_noise};
use crate::estimation::most_likely_noise::Search;
use crate::numeric::distributions::signed_rank;
use crate::numeric::parallel;
use crate::recording::campaign::Prepared;
use crate::recording::odometry_noise::OdometryNoise;
use crate::residuals::auxiliary_effects::AUXILIARY_EFFECTS;
use crate::residuals::basis_functions::FUNCTIONS;
use crate::residuals::floor_location::visited;
use crate::residuals::regressor::Regressor;

/// Least gain of (1): chance gives the best of a few dozen groups less.
const GAIN_MIN: f64 = 16.0;
/// Most groups that are taken up.
const GROUPS_MAX: usize = 12;
/// How often the noise is estimated anew.
const ROUNDS_MAX: usize = 3;
/// (2): squared displacements have to fall by this share, and so often chance gives as many runs that get better.
const FALL_MIN: f64 = 0.2;
const FALL_BY_CHANCE: f64 = 0.1;
/// Most groups that are taken up by (2).
const FALLS_MAX: usize = 2;
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
    /// By how many times the model's errors exceed the reachable error, as displacements of the wheels.
    pub fn excess(&self, track_width_m: f64) -> f64 {
        let of = |errors: &Errors| displacement_m(errors, track_width_m);
        let reachable = of(&self.reachable);
        if reachable > 0.0 { of(&self.model) / reachable } else { 1.0 }
    }
}

/// Errors of position and heading as one number: the displacement of the wheels' contact points \[m\].
pub(crate) fn displacement_m(errors: &Errors, track_width_m: f64) -> f64 {
    errors.position_rms_m.hypot(errors.heading_rms_rad * track_width_m / 2.0)
}

/// The lower of two reachable errors, as displacements of the wheels.
pub(crate) fn lower(one: &Errors, other: &Errors, track_width_m: f64) -> Errors {
    let lower = displacement_m(other, track_width_m) < displacement_m(one, track_width_m);
    if lower { *other } else { *one }
}

/// A group of columns that may be taken up.
struct Group {
    regressor: Option<Regressor>,
    columns: Vec<usize>,
}

/// Fits a flexible model that begins with a fitted one.
pub(crate) fn flexible(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    catalogue: &[&dyn Effect],
) -> Flexible {
    let patches = visited(prepared);
    let pool: Vec<(Option<Regressor>, Term<'_>)> = pool(prepared, fitted, catalogue)
        .into_iter()
        .chain(patches.iter().map(|patch| (Some(Regressor::Place), zero(patch))))
        .collect();
    let thinned = thinned(prepared);
    let track_width_m = prepared.robot.track_width_m;
    let is_lower = |one: &FlexibleFit<'_>, other: &FlexibleFit<'_>| {
        let of = |fit: &FlexibleFit<'_>| displacement_m(&fit.errors, track_width_m);
        of(one) < of(other)
    };
    let search = GroupSearch { prepared, thinned: &thinned, pool: &pool };
    let model = search.evaluated(fitted.terms.clone(), Vec::new(), fitted.noise);
    let mut best = search.with_groups_worth_adding(&model);
    if !is_lower(&best, &model) {
        best = model.clone();
    }
    for _ in 0..FALLS_MAX {
        let Some(index) = search.lowers_tracks(&best) else { break };
        // With it in the model there is less noise, and more is seen.
        let next = search.with_groups_worth_adding(&search.with(&best, &[index]));
        if !is_lower(&next, &best) {
            break;
        }
        best = next;
    }
    Flexible {
        reachable: best.errors,
        model: model.errors,
        noise: best.noise,
        depends_on: best.taken.iter().map(|index| pool[*index].0).collect(),
    }
}

/// Terms with the groups that were taken up, by their places in the pool.
#[derive(Clone)]
struct FlexibleFit<'a> {
    terms: Vec<Term<'a>>,
    taken: Vec<usize>,
    noise: OdometryNoise,
    /// Cross-validated.
    errors: Errors,
}

/// What the groups are chosen from, and by which runs.
struct GroupSearch<'c, 'a> {
    prepared: &'c Prepared,
    thinned: &'c Prepared,
    pool: &'c [(Option<Regressor>, Term<'a>)],
}

impl<'a> GroupSearch<'_, 'a> {
    fn evaluated(
        &self,
        terms: Vec<Term<'a>>,
        taken: Vec<usize>,
        noise: OdometryNoise,
    ) -> FlexibleFit<'a> {
        let errors = cross_validated_of(self.prepared, self.thinned, &terms, &noise);
        FlexibleFit { terms, taken, noise, errors }
    }

    /// The fit with these groups as well.
    fn with(&self, fit: &FlexibleFit<'a>, more: &[usize]) -> FlexibleFit<'a> {
        let (terms, noise) = self.fitted_with(&fit.terms, more, fit.noise);
        self.evaluated(terms, [&fit.taken, more].concat(), noise)
    }

    /// These terms and groups at their best values, and the noise that they leave.
    fn fitted_with(
        &self,
        terms: &[Term<'a>],
        more: &[usize],
        noise: OdometryNoise,
    ) -> (Vec<Term<'a>>, OdometryNoise) {
        let added = more.iter().map(|index| self.pool[*index].1.clone());
        let terms = refitted(self.thinned, terms.iter().cloned().chain(added).collect(), &noise);
        match self.prepared.noise {
            Some(_) => (terms, noise),
            None => {
                let noise = fit_noise(self.prepared, &terms, noise, Search::Near);
                (terms, noise)
            }
        }
    }

    /// The fit with all groups that are worth adding by (1), in a few rounds.
    fn with_groups_worth_adding(&self, fit: &FlexibleFit<'a>) -> FlexibleFit<'a> {
        let FlexibleFit { mut terms, mut taken, mut noise, .. } = fit.clone();
        let before = taken.len();
        for _ in 0..ROUNDS_MAX {
            let more = groups_worth_adding(self.thinned, &terms, self.pool, &taken, &noise);
            if more.is_empty() {
                break;
            }
            (terms, noise) = self.fitted_with(&terms, &more, noise);
            taken.extend(more);
            if taken.len() >= GROUPS_MAX {
                break;
            }
        }
        if taken.len() == before { fit.clone() } else { self.evaluated(terms, taken, noise) }
    }

    /// The group that lowers displacements most by (2), if there is one.
    fn lowers_tracks(&self, fit: &FlexibleFit<'a>) -> Option<usize> {
        lowers_tracks(self.thinned, &fit.terms, self.pool, &fit.taken, &fit.noise)
    }
}

fn zero(effect: &dyn Effect) -> Term<'_> {
    Term::new(effect, vec![0.0; effect.facts().parameters.len()])
}

/// All groups but places.
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
    let functions = FUNCTIONS.iter().map(|basis| (Some(basis.regressor), zero(basis)));
    let auxiliary = AUXILIARY_EFFECTS.iter().map(|one| (Some(one.regressor), zero(one)));
    known.chain(functions).chain(auxiliary).collect()
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

/// The groups that are worth adding to these terms, by their place in the pool.
fn groups_worth_adding(
    prepared: &Prepared,
    terms: &[Term<'_>],
    pool: &[(Option<Regressor>, Term<'_>)],
    taken: &[usize],
    noise: &OdometryNoise,
) -> Vec<usize> {
    let open: Vec<usize> = (0..pool.len()).filter(|index| !taken.contains(index)).collect();
    let all: Vec<Term<'_>> =
        terms.iter().cloned().chain(open.iter().map(|index| pool[*index].1.clone())).collect();
    let placed = PlacedTerm::place(&all);
    let equations = CampaignEquations::gather(prepared, &placed, noise);
    let mut model: Vec<usize> =
        placed[..terms.len()].iter().flat_map(PlacedTerm::columns).collect();
    let shown = |column: &usize| {
        // At its greatest it moves a pose by more than a sigma.
        let spread = equations.priors[*column].spread;
        equations.total.gram[(*column, *column)] * spread * spread > 1.0
    };
    let mut groups: Vec<(usize, Group)> = open
        .iter()
        .zip(&placed[terms.len()..])
        .map(|(index, term)| {
            let columns = term.amplitudes().into_iter().filter(shown).collect();
            (*index, Group { regressor: pool[*index].0, columns })
        })
        .filter(|(_, group)| !group.columns.is_empty())
        .collect();
    let mut more = Vec::new();
    let overestimated = overestimated(prepared, &left_out(&equations, &model));
    while taken.len() + more.len() < GROUPS_MAX {
        let without = left_out(&equations, &model);
        let gains = parallel::map(&groups, |(_, group)| {
            let both: Vec<usize> = model.iter().chain(&group.columns).copied().collect();
            let with = left_out(&equations, &both);
            let gain = without.iter().zip(&with).map(|(without, with)| without - with);
            overestimated * gain.sum::<f64>()
        });
        let best = (0..groups.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b]));
        let Some(best) = best.filter(|best| gains[*best] > GAIN_MIN) else { break };
        let (index, group) = groups.remove(best);
        model.extend(group.columns);
        more.push(index);
        // Of an effect with shapes, one start is enough.
        let id = pool[index].1.effect.facts().id;
        if group.regressor.is_none() {
            groups.retain(|(other, _)| {
                pool[*other].0.is_some() || pool[*other].1.effect.facts().id != id
            });
        }
    }
    more
}

/// Few numbers tell the variance of the noise to such a factor.
const NOISE_TOLD: f64 = 1.5;

/// By how many times the variance of the noise is overestimated beyond doubt, at least 1: how many numbers were measured,
/// over the chi^2 of runs left out.
///
/// Where few numbers are measured, as at the ends of runs only, what no effect explains makes the noise so large that no
/// group could gain enough.
fn overestimated(prepared: &Prepared, left_out: &[f64]) -> f64 {
    let chi_squared = left_out.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    (numbers_measured(prepared) / (NOISE_TOLD * chi_squared)).max(1.0)
}

/// How many numbers were measured, but for the starts of runs.
pub(crate) fn numbers_measured(prepared: &Prepared) -> f64 {
    let poses = prepared.runs.iter().flat_map(|run| run.recording.measured_poses.iter().skip(1));
    let numbers = poses.map(|pose| {
        f64::from(2 * u8::from(pose.position_m.is_some()) + u8::from(pose.heading_rad.is_some()))
    });
    numbers.sum()
}

/// The group that lowers displacements of runs left out most, if by enough: (2).
fn lowers_tracks(
    prepared: &Prepared,
    terms: &[Term<'_>],
    pool: &[(Option<Regressor>, Term<'_>)],
    taken: &[usize],
    noise: &OdometryNoise,
) -> Option<usize> {
    let open: Vec<usize> = (0..pool.len()).filter(|index| !taken.contains(index)).collect();
    let all: Vec<Term<'_>> =
        terms.iter().cloned().chain(open.iter().map(|index| pool[*index].1.clone())).collect();
    let placed = PlacedTerm::place(&all);
    let equations = CampaignEquations::gather(prepared, &placed, noise);
    let model: Vec<usize> = placed[..terms.len()].iter().flat_map(PlacedTerm::columns).collect();
    let track_width_m = prepared.robot.track_width_m;
    let chi_squared = |columns: &[usize]| left_out(&equations, columns).iter().sum::<f64>();
    let without = chi_squared(&model);
    let overestimated = overestimated(prepared, &[without]);
    let mut both = placed[..terms.len()].to_vec();
    let before = tracks(prepared, (&equations, &both), &model, noise);
    let mut best: Option<(f64, usize)> = None;
    for (index, term) in open.iter().zip(&placed[terms.len()..]) {
        let columns: Vec<usize> = model.iter().copied().chain(term.amplitudes()).collect();
        if overestimated * (without - chi_squared(&columns)) < GAIN_MIN {
            continue;
        }
        both.push(term.clone());
        let after = tracks(prepared, (&equations, &both), &columns, noise);
        both.pop();
        let left = |errors: &TrackErrors| errors.displacement_m2(track_width_m);
        let fall = 1.0 - left(&after) / left(&before).max(f64::MIN_POSITIVE);
        let each = |errors: &TrackErrors| errors.displacements_m(track_width_m);
        let gains: Vec<f64> =
            each(&before).iter().zip(each(&after)).map(|(before, after)| before - after).collect();
        if fall > FALL_MIN
            && signed_rank(&gains) < FALL_BY_CHANCE
            && best.is_none_or(|(most, _)| fall > most)
        {
            best = Some((fall, *index));
        }
    }
    best.map(|(_, index)| index)
}

/// chi^2 of each run, with these columns fitted to all other runs.
pub(super) fn left_out(equations: &CampaignEquations, columns: &[usize]) -> Vec<f64> {
    let each = equations.folds.iter().map(|fold| equations.chi_squared_left_out(fold, columns));
    each.collect()
}

/// These terms at their best values.
fn refitted<'a>(prepared: &Prepared, terms: Vec<Term<'a>>, noise: &OdometryNoise) -> Vec<Term<'a>> {
    let placed = PlacedTerm::place(&terms);
    let equations = CampaignEquations::gather(prepared, &placed, noise);
    let columns: Vec<usize> = placed.iter().flat_map(PlacedTerm::amplitudes).collect();
    let delta = equations.best(&equations.total, &columns);
    let mut terms = terms;
    for (term, placed) in terms.iter_mut().zip(&placed) {
        let first = placed.columns().start;
        for (column, step) in columns.iter().zip(delta.iter()) {
            if placed.columns().contains(column) {
                term.values[column - first] += step;
            }
        }
    }
    terms
}

/// Cross-validated errors on all poses, with normal equations of some of them.
fn cross_validated_of(
    prepared: &Prepared,
    thinned: &Prepared,
    terms: &[Term<'_>],
    noise: &OdometryNoise,
) -> Errors {
    let placed = PlacedTerm::place(terms);
    let equations = CampaignEquations::gather(thinned, &placed, noise);
    let columns: Vec<usize> = placed.iter().flat_map(PlacedTerm::amplitudes).collect();
    cross_validated(prepared, (&equations, &placed), &columns, noise)
}

#[cfg(test)]
mod tests;
