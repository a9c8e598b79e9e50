//! Do the residuals of a model depend on anything?
//!
//! Each regressor has a few auxiliary effects: turns, travels and drifts in proportion to functions of it. They go through
//! the same filter as the effects, so that the test is of what they would do to the track. The strongest
//! significant regressor is added to the model and the others are tested again, so that regressors which merely
//! resemble it are not named too. Ripples and heavy tails come last; they have tests of their own.
//!
//! No effect is named here, and nothing found changes a fit.

use core::ops::Range;

use serde::{Deserialize, Serialize};

use crate::effect::composition::{PlacedTerm, Term};
use crate::effect::definition::Effect;
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::fit::Fitted;
use crate::estimation::tolerance::tolerance_m;
use crate::numeric::distributions::false_discovery_rates;
use crate::recording::campaign::Prepared;
use crate::residuals::each_run::each_run_by_itself;
use crate::residuals::heavy_tails::heavy_tails;
use crate::residuals::lack_of_fit::DrivenAgain;
use crate::residuals::place_waves::strongest;
use crate::residuals::ripple::ripple;
use crate::residuals::uneven_runs::uneven_runs;
use crate::residuals::whiteness::persisting;
use crate::residuals::worth::least_move_m;
use crate::selection::effect_test::{run_scatter_in_the_mean, scatter, test_effect};
use crate::selection::gain::Hypothesis;

use super::auxiliary_effects::{AFTER_A_TURN, AUXILIARY_EFFECTS, AuxiliaryEffect, OF_A_RUN};
use super::expression::Expression;
use super::floor_location::{FloorPatch, FloorSearch, PlaceSeen, search_floor};
use super::regressor::Regressor;
use super::sudden_motion::SuddenMotion;

/// At most this share of the named regressors is wrong: of 600 sound robots, three were flagged at 1 %, none of them at this.
const FALSE_DISCOVERY_RATE: f64 = 0.003;

/// What chance gives more seldom is there, whether it matters or not: this is no multiple test's luck.
const BEYOND_DOUBT: f64 = 1e-9;

/// From this many runs on, a few of them may have something that the others do not have.
const MANY_RUNS: usize = 8;

/// Residuals depend on many things a little; at most this many are named.
const DEPENDS_ON_MAX: usize = 4;

/// At most this many rounds: one place may need several functions, and is named once.
const ROUNDS_MAX: usize = 8;

/// Significance level of a ripple.
const RIPPLE_P: f64 = 1e-4;

/// What the residuals depend on, if on anything.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Unexplained {
    /// Whether they depend on anything.
    pub structure: bool,
    /// The regressors that they depend on, strongest first.
    pub depends_on: Vec<Regressor>,
    /// Probability by chance of at least as much of the strongest regressor, corrected for how many were tested.
    pub p_value: f64,
    /// Where on the floor, if they come from one place \[m\].
    pub place_m: Option<[f64; 2]>,
    /// The places that several runs came to.
    pub places: Vec<PlaceSeen>,
    /// The measured poses have more outliers than noise has.
    #[serde(default)]
    pub outliers: bool,
    /// Whether errors come back when a run is driven again.
    #[serde(default)]
    pub driven_again: DrivenAgain,
    /// How far the robot turns at random in a metre \[rad\], where that is more than wheels do and no run that was driven
    /// again tells whether it is noise.
    #[serde(default)]
    pub random_turn_rad: Option<f64>,
    /// What they may depend on, not beyond all doubt, and by so little that it moves the robot by less than the tolerance.
    #[serde(default)]
    pub slight: Vec<Regressor>,
    /// The names of runs that are off by far more than the others, the one that is furthest off first.
    pub runs_off: Vec<String>,
    /// Where the robot at once moved as its wheels did not.
    #[serde(default)]
    pub sudden: Vec<SuddenMotion>,
    /// Cross-validated position error above the reachable one \[m\]: the root of the difference of squares.
    pub size_m: f64,
    /// The simple equation that would take the model nearly to the reachable error, if there is one.
    pub expression: Option<Expression>,
}

impl Unexplained {
    /// Whether outliers of the measured poses are all that is unexplained.
    pub fn only_outliers(&self) -> bool {
        self.outliers && self.depends_on.len() == 1
    }

    /// Names a regressor, once: as one that matters, or not.
    fn name(&mut self, regressor: Regressor, matters: bool) {
        let named = if matters { &mut self.depends_on } else { &mut self.slight };
        if !named.contains(&regressor) {
            named.push(regressor);
        }
    }

    /// Notes a finding; the p-value stays that of the first one.
    fn note(&mut self, p_value: f64) {
        if !self.structure {
            self.p_value = p_value;
        }
        self.structure = true;
    }
}

/// Tests the residuals against every regressor, for ripples, for runs unlike the others and for heavy tails.
pub(crate) fn unexplained(prepared: &Prepared, fitted: &Fitted<'_>) -> Unexplained {
    let mut found = of_regressors(prepared, fitted);
    let p_value = ripple(prepared, fitted);
    if p_value < RIPPLE_P {
        found.note(p_value);
        // Whatever else is found may come from where the crests of the ripple happened to stop.
        found.depends_on.retain(|regressor| *regressor != Regressor::WheelAngle);
        found.depends_on.insert(0, Regressor::WheelAngle);
    }
    if let Some(uneven) = uneven_runs(prepared, fitted) {
        found.note(uneven.p_value);
        if !found.depends_on.contains(&uneven.regressor) {
            found.depends_on.push(uneven.regressor);
        }
    }
    if let Some((_, p_value)) = strongest(prepared, fitted) {
        found.note(p_value);
        if !found.depends_on.contains(&Regressor::Place) {
            found.depends_on.push(Regressor::Place);
        }
    }
    if let Some(persisting) = persisting(prepared, fitted) {
        found.note(persisting.p_value);
        if !found.depends_on.contains(&persisting.regressor) {
            found.depends_on.push(persisting.regressor);
        }
    }
    let Some(tails) = heavy_tails(prepared, fitted) else { return found };
    found.outliers = true;
    found.note(tails.p_value);
    if tails.dominates {
        found.p_value = tails.p_value;
    }
    found.depends_on.retain(|regressor| *regressor != tails.regressor);
    let place = if tails.dominates { 0 } else { found.depends_on.len() };
    found.depends_on.insert(place, tails.regressor);
    found
}

/// A regressor that is still to be tested.
struct OpenRegressor<'a> {
    regressor: Regressor,
    effect: &'a dyn Effect,
    /// Its columns, as far as the campaign's motion shows them.
    columns: Vec<usize>,
    /// Where, if it is a place \[m\].
    patch_m: Option<[f64; 2]>,
    /// Probability by chance of as much, given all others that were found.
    p_value: f64,
}

impl OpenRegressor<'_> {
    /// A regressor that hardly changes within a run is tested against the scatter between runs.
    fn is_of_runs(&self) -> bool {
        self.regressor.is_of_runs()
    }
}

/// The evidence for an open regressor.
#[derive(Clone, Copy)]
struct Finding {
    /// Its place in the list of open ones.
    index: usize,
    p_value: f64,
    /// Its cross-validated gain over the dispersion.
    merit: f64,
}

/// Tests the residuals against every regressor.
fn of_regressors(prepared: &Prepared, fitted: &Fitted<'_>) -> Unexplained {
    let FloorSearch { patches, tested, seen } = search_floor(prepared, fitted);
    let in_model = fitted.terms.len();
    let terms = with_auxiliary(fitted, &patches);
    let equations = CampaignEquations::gather(prepared, &terms, &fitted.noise);
    let columns = |term: &PlacedTerm<'_>| term.columns().collect::<Vec<usize>>();
    let mut model: Vec<usize> = terms[..in_model].iter().flat_map(columns).collect();
    let own: Vec<usize> = terms.last().map(columns).unwrap_or_default();
    let mut open = open_regressors(&equations, &terms[in_model..], &patches);
    let is_wave = |regressor: &&OpenRegressor<'_>| regressor.regressor == Regressor::WheelAngle;
    let waves: Vec<Vec<usize>> =
        open.iter().filter(is_wave).map(|wave| wave.columns.clone()).collect();
    let mut found = Unexplained { p_value: 1.0, ..Unexplained::default() };
    let many = prepared.runs.len() >= MANY_RUNS;
    let asked = open.iter().filter(|one| one.patch_m.is_none()).count() + tested;
    let mut within = 1.0;
    let (base, mut between, mut taken) = (model.clone(), 1.0, Vec::new());
    for _ in 0..ROUNDS_MAX {
        if open.is_empty() || count_of_regressors(&taken) == DEPENDS_ON_MAX {
            break;
        }
        // Places do not measure how much runs disagree: most runs hardly see most places.
        let usual = open.iter().filter(|regressor| regressor.patch_m.is_none());
        let usual = usual.map(|regressor| (&model[..], &regressor.columns[..]));
        within = scatter(&equations, usual);
        between = within.max(run_scatter_in_the_mean(&equations, &model, &own));
        let findings = findings(&equations, &model, &open, (within, between), many, tested);
        let p_values: Vec<f64> = findings.iter().map(|finding| finding.p_value).collect();
        let rates = false_discovery_rates(&p_values);
        if !found.structure {
            found.p_value = rates.iter().copied().fold(1.0, f64::min);
        }
        let Some((best, _)) = findings
            .iter()
            .zip(&rates)
            .filter(|(_, rate)| **rate < FALSE_DISCOVERY_RATE)
            .max_by(|(a, _), (b, _)| a.merit.total_cmp(&b.merit))
        else {
            break;
        };
        found.structure = true;
        let best = open.remove(best.index);
        found.place_m = found.place_m.or(best.patch_m);
        model.extend(&best.columns);
        taken.push(best);
    }
    found.places = seen;
    let taken = by_own_gain(&equations, &base, taken, (within, between));
    let with_taken = taken.iter().flat_map(|one| &one.columns);
    let with_taken: Vec<usize> = base.iter().chain(with_taken).copied().collect();
    let tolerance_m = tolerance_m(prepared, &fitted.noise);
    for OpenRegressor { regressor, columns, p_value, .. } in &taken {
        let (model, own) = ((&equations, &terms[..]), (&columns[..], *p_value));
        let matters = *p_value < BEYOND_DOUBT
            || least_move_m(prepared, model, &with_taken, own, asked) >= tolerance_m;
        found.name(*regressor, matters);
    }
    found.structure = !found.depends_on.is_empty();
    found.place_m = found.place_m.filter(|_| found.depends_on.contains(&Regressor::Place));
    if counts_start_anew(prepared) && !found.depends_on.contains(&Regressor::WheelAngle) {
        let p_value = |wave: &Vec<usize>| each_run_by_itself(&equations, (&model, wave), within);
        let p_value = waves.iter().map(p_value).fold(1.0, f64::min);
        if p_value < RIPPLE_P {
            found.note(p_value);
            found.depends_on.push(Regressor::WheelAngle);
        }
    }
    found
}

fn count_of_regressors(taken: &[OpenRegressor<'_>]) -> usize {
    let repeated = |index: &usize| {
        taken[..*index].iter().any(|earlier| earlier.regressor == taken[*index].regressor)
    };
    (0..taken.len()).filter(|index| !repeated(index)).count()
}

/// Regressors by what each explains beside all others, most first; without those that explain nothing any more.
///
/// What is taken first may only resemble two that are taken after it, and together explain more.
fn by_own_gain<'a>(
    equations: &CampaignEquations,
    base: &[usize],
    mut taken: Vec<OpenRegressor<'a>>,
    (within, between): (f64, f64),
) -> Vec<OpenRegressor<'a>> {
    loop {
        let own = |index: usize| {
            let others = taken.iter().enumerate().filter(|(other, _)| *other != index);
            let others = others.flat_map(|(_, one)| one.columns.iter().copied());
            let model: Vec<usize> = base.iter().copied().chain(others).collect();
            let OpenRegressor { columns: asked, effect, .. } = &taken[index];
            let scatter = if taken[index].is_of_runs() { between } else { within };
            let hypothesis =
                Hypothesis { model: &model, asked, effect: *effect, geometry: &[], scatter };
            let test = test_effect(equations, &hypothesis);
            let counts = test.cross_validated_gain > 0.0 && test.p_value < FALSE_DISCOVERY_RATE;
            (counts, test.cross_validated_gain / test.dispersion, test.p_value)
        };
        let each: Vec<(bool, f64, f64)> = (0..taken.len()).map(own).collect();
        for (one, (.., p_value)) in taken.iter_mut().zip(&each) {
            one.p_value = *p_value;
        }
        let mut order: Vec<(usize, (bool, f64))> =
            each.iter().map(|(counts, merit, _)| (*counts, *merit)).enumerate().collect();
        order.sort_by(|(_, (_, a)), (_, (_, b))| b.total_cmp(a));
        match order.last() {
            Some(&(index, (false, _))) if taken.len() > 1 => drop(taken.remove(index)),
            _ => {
                let mut slots: Vec<Option<OpenRegressor<'a>>> =
                    taken.into_iter().map(Some).collect();
                return order.iter().filter_map(|(index, _)| slots[*index].take()).collect();
            }
        }
    }
}

/// The model's terms, then the auxiliary effects, the places, and what may differ from run to run.
fn with_auxiliary<'a>(fitted: &Fitted<'a>, patches: &'a [FloorPatch]) -> Vec<PlacedTerm<'a>> {
    let auxiliary = auxiliary_effects().map(|one| one as &dyn Effect);
    let added =
        auxiliary.chain(patches.iter().map(|patch| patch as &dyn Effect)).chain([&OF_A_RUN as _]);
    let mut terms = fitted.terms.clone();
    terms.extend(added.map(|effect| {
        let values = vec![0.0; effect.facts().parameters.len()];
        Term::new(effect, values)
    }));
    PlacedTerm::place(&terms)
}

/// All that are tested.
fn auxiliary_effects() -> impl Iterator<Item = &'static AuxiliaryEffect> {
    AUXILIARY_EFFECTS.iter().chain(&AFTER_A_TURN)
}

/// The regressors that the campaign's motion shows: of `added`, the auxiliary effects and the places.
fn open_regressors<'a>(
    equations: &CampaignEquations,
    added: &[PlacedTerm<'a>],
    patches: &[FloorPatch],
) -> Vec<OpenRegressor<'a>> {
    let auxiliary = auxiliary_effects().map(|one| (one.regressor, None));
    let places = patches.iter().map(|patch| (Regressor::Place, Some(patch.at_m)));
    let open = |((regressor, patch_m), term): (_, &PlacedTerm<'a>)| {
        let columns = visible(equations, term.columns());
        OpenRegressor { regressor, effect: term.effect, columns, patch_m, p_value: 1.0 }
    };
    let all = auxiliary.chain(places).zip(added).map(open);
    all.filter(|regressor| !regressor.columns.is_empty()).collect()
}

/// The evidence for each open regressor; of all places, for the best one only.
fn findings(
    equations: &CampaignEquations,
    model: &[usize],
    open: &[OpenRegressor<'_>],
    (within, between): (f64, f64),
    many: bool,
    tested_places: usize,
) -> Vec<Finding> {
    let finding = |(index, regressor): (usize, &OpenRegressor<'_>)| {
        let of_runs = regressor.is_of_runs();
        let scatter = if of_runs { between } else { within };
        let (asked, effect) = (&regressor.columns, regressor.effect);
        let hypothesis = Hypothesis { model, asked, effect, geometry: &[], scatter };
        let test = test_effect(equations, &hypothesis);
        // A finding says that something is there, not what: among many runs, a few may show it.
        let p_value = if many && !of_runs { test.p_value_of_many } else { test.p_value };
        // One run alone does not tell a place from a disturbance that the run happened to have there.
        let more_runs = regressor.patch_m.is_none() || test.touched > 1;
        let counts = test.cross_validated_gain > 0.0 && more_runs;
        let p_value = if counts { p_value } else { 1.0 };
        Finding { index, p_value, merit: test.cross_validated_gain / test.dispersion }
    };
    let all: Vec<Finding> = open.iter().enumerate().map(finding).collect();
    let (patches, mut rest): (Vec<_>, Vec<_>) =
        all.into_iter().partition(|finding| open[finding.index].patch_m.is_some());
    let best = patches.into_iter().max_by(|a, b| a.merit.total_cmp(&b.merit));
    // Bonferroni: the best of this many.
    let corrected = |p_value: f64| (p_value * tested_places as f64).min(1.0);
    rest.extend(best.map(|best| Finding { p_value: corrected(best.p_value), ..best }));
    rest
}

/// Whether the counts begin at the same number in every run: the angle of a wheel is then unknown across runs.
pub(crate) fn counts_start_anew(prepared: &Prepared) -> bool {
    let mut starts = prepared.runs.iter().filter_map(|run| run.motion.steps.first());
    let Some(first) = starts.next() else { return false };
    let mut others = starts.peekable();
    others.peek().is_some() && others.all(|step| step.phi_rad == first.phi_rad)
}

/// The columns that the campaign's motion shows at all.
fn visible(equations: &CampaignEquations, columns: Range<usize>) -> Vec<usize> {
    // At the widest value of an auxiliary effect it does more than one sigma: a real dependence does far more.
    columns.filter(|column| equations.total.gram[(*column, *column)] > 1.0).collect()
}
