//! Which groups of functions does a flexible model take up? [`super::flexible_model`] says what they are.
//!
//! ```text
//! gain of a group = sum over runs of chi^2(model) - chi^2(model + group), both fitted to all other runs     (1)
//! ```
//!
//! Where such groups together predict tracks worse, groups are chosen by displacements of runs left out (2).

use std::cell::OnceCell;
use std::rc::Rc;

use crate::effect::composition::{PlacedTerm, Term};
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::errors::{Errors, TrackErrors, cross_validated, displacement_m, tracks};
use crate::estimation::fit::fit_noise;
use crate::estimation::most_likely_noise::Search;
use crate::numeric::distributions::signed_rank;
use crate::numeric::parallel;
use crate::recording::campaign::Prepared;
use crate::recording::odometry_noise::OdometryNoise;
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
/// A group of columns that may be taken up.
struct Group {
    regressor: Option<Regressor>,
    columns: Vec<usize>,
}

/// Terms with the groups that were taken up, by their places in the pool.
#[derive(Clone)]
pub(super) struct FlexibleFit<'a> {
    pub terms: Vec<Term<'a>>,
    pub taken: Vec<usize>,
    pub noise: OdometryNoise,
    /// Cross-validated.
    pub errors: Errors,
}

/// What the groups are chosen from, and by which runs.
pub(super) struct GroupSearch<'c, 'a> {
    prepared: &'c Prepared,
    /// With fewer poses: the groups' shapes are wide.
    thinned: &'c Prepared,
    /// Whether a round of groups that leaves larger errors is taken back.
    takes_back: bool,
    pool: &'c [(Option<Regressor>, Term<'a>)],
    /// What is open beside the model alone, where a search begins more than once.
    beside_model: OnceCell<Rc<OpenGroups<'a>>>,
}

/// The groups that are not taken up, with the equations of a model and of all of them.
struct OpenGroups<'a> {
    /// Their places in the pool.
    open: Vec<usize>,
    /// The terms of the model, then theirs.
    placed: Vec<PlacedTerm<'a>>,
    equations: CampaignEquations,
}

impl<'c, 'a> GroupSearch<'c, 'a> {
    /// Among the groups of this pool, on a campaign and on the same with fewer poses.
    pub fn new(
        (prepared, thinned): (&'c Prepared, &'c Prepared),
        takes_back: bool,
        pool: &'c [(Option<Regressor>, Term<'a>)],
    ) -> Self {
        Self { prepared, thinned, takes_back, pool, beside_model: OnceCell::new() }
    }

    pub fn evaluated(
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

    pub fn is_lower(&self, one: &FlexibleFit<'_>, other: &FlexibleFit<'_>) -> bool {
        let of =
            |fit: &FlexibleFit<'_>| displacement_m(&fit.errors, self.prepared.robot.track_width_m);
        of(one) < of(other)
    }

    /// The fit with the groups that are worth adding by (1), in a few rounds.
    pub fn with_groups_worth_adding(&self, fit: &FlexibleFit<'a>) -> FlexibleFit<'a> {
        let (mut last, mut best) = (fit.clone(), fit.clone());
        for _ in 0..ROUNDS_MAX {
            let more = self.groups_worth_adding(&last);
            if more.is_empty() {
                break;
            }
            last = self.with(&last, &more);
            if !self.takes_back || self.is_lower(&last, &best) {
                best = last.clone();
            }
            if last.taken.len() >= GROUPS_MAX {
                break;
            }
        }
        best
    }

    /// The fit with the groups that lower displacements most, by (2), and with those that are worth adding beside them.
    pub fn with_falls(&self, fit: FlexibleFit<'a>) -> FlexibleFit<'a> {
        let mut best = fit;
        for _ in 0..FALLS_MAX {
            let Some(index) = self.lowers_tracks(&best) else { break };
            // With it in the model there is less noise, and more is seen.
            let next = self.with_groups_worth_adding(&self.with(&best, &[index]));
            if !self.is_lower(&next, &best) {
                break;
            }
            best = next;
        }
        best
    }

    /// What this fit may take up besides. A fit without groups is that of the model alone.
    fn open_groups(&self, fit: &FlexibleFit<'a>) -> Rc<OpenGroups<'a>> {
        let gather = || {
            let open: Vec<usize> =
                (0..self.pool.len()).filter(|index| !fit.taken.contains(index)).collect();
            let groups = open.iter().map(|index| self.pool[*index].1.clone());
            let all: Vec<Term<'a>> = fit.terms.iter().cloned().chain(groups).collect();
            let placed = PlacedTerm::place(&all);
            let equations = CampaignEquations::gather(self.thinned, &placed, &fit.noise);
            Rc::new(OpenGroups { open, placed, equations })
        };
        if fit.taken.is_empty() { self.beside_model.get_or_init(gather).clone() } else { gather() }
    }

    /// The groups that are worth adding to this fit, by their place in the pool.
    fn groups_worth_adding(&self, fit: &FlexibleFit<'a>) -> Vec<usize> {
        let found = self.open_groups(fit);
        let OpenGroups { open, placed, equations } = &*found;
        let (of_model, of_groups) = placed.split_at(fit.terms.len());
        let mut model: Vec<usize> = of_model.iter().flat_map(PlacedTerm::columns).collect();
        let shown = |column: &usize| {
            // At its greatest it moves a pose by more than a sigma.
            let spread = equations.priors[*column].spread;
            equations.total.gram[(*column, *column)] * spread * spread > 1.0
        };
        let mut groups: Vec<(usize, Group)> = open
            .iter()
            .zip(of_groups)
            .map(|(index, term)| {
                let columns = term.amplitudes().into_iter().filter(shown).collect();
                (*index, Group { regressor: self.pool[*index].0, columns })
            })
            .filter(|(_, group)| !group.columns.is_empty())
            .collect();
        let mut more = Vec::new();
        let overestimated = overestimated(self.thinned, &left_out(equations, &model));
        while fit.taken.len() + more.len() < GROUPS_MAX {
            let without = left_out(equations, &model);
            let gains = parallel::map(&groups, |(_, group)| {
                let both: Vec<usize> = model.iter().chain(&group.columns).copied().collect();
                let with = left_out(equations, &both);
                let gain = without.iter().zip(&with).map(|(without, with)| without - with);
                overestimated * gain.sum::<f64>()
            });
            let best = (0..groups.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b]));
            let Some(best) = best.filter(|best| gains[*best] > GAIN_MIN) else { break };
            let (index, group) = groups.remove(best);
            model.extend(group.columns);
            more.push(index);
            // Of an effect with shapes, one start is enough.
            let id = self.pool[index].1.effect.facts().id;
            if group.regressor.is_none() {
                groups.retain(|(other, _)| {
                    self.pool[*other].0.is_some() || self.pool[*other].1.effect.facts().id != id
                });
            }
        }
        more
    }

    /// The group that lowers displacements of runs left out most, if by enough: (2).
    fn lowers_tracks(&self, fit: &FlexibleFit<'a>) -> Option<usize> {
        let (prepared, noise) = (self.thinned, &fit.noise);
        let found = self.open_groups(fit);
        let OpenGroups { open, placed, equations } = &*found;
        let (of_model, of_groups) = placed.split_at(fit.terms.len());
        let model: Vec<usize> = of_model.iter().flat_map(PlacedTerm::columns).collect();
        let track_width_m = prepared.robot.track_width_m;
        let chi_squared = |columns: &[usize]| left_out(equations, columns).iter().sum::<f64>();
        let without = chi_squared(&model);
        let overestimated = overestimated(prepared, &[without]);
        let before = tracks(prepared, (equations, of_model), &model, noise);
        let candidates: Vec<(&usize, &PlacedTerm<'_>)> = open.iter().zip(of_groups).collect();
        let falls = parallel::map(&candidates, |(index, term)| {
            let columns: Vec<usize> = model.iter().copied().chain(term.amplitudes()).collect();
            if overestimated * (without - chi_squared(&columns)) < GAIN_MIN {
                return None;
            }
            let both: Vec<PlacedTerm<'_>> = of_model.iter().chain([*term]).cloned().collect();
            let after = tracks(prepared, (equations, &both), &columns, noise);
            let left = |errors: &TrackErrors| errors.displacement_m2(track_width_m);
            let fall = 1.0 - left(&after) / left(&before).max(f64::MIN_POSITIVE);
            let each = |errors: &TrackErrors| errors.displacements_m(track_width_m);
            let gains: Vec<f64> = each(&before)
                .iter()
                .zip(each(&after))
                .map(|(before, after)| before - after)
                .collect();
            (fall > FALL_MIN && signed_rank(&gains) < FALL_BY_CHANCE).then_some((fall, **index))
        });
        let mut best: Option<(f64, usize)> = None;
        for (fall, index) in falls.into_iter().flatten() {
            if best.is_none_or(|(most, _)| fall > most) {
                best = Some((fall, index));
            }
        }
        best.map(|(_, index)| index)
    }
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
