//! What is left over once the model has said its part: does it depend on anything?
//!
//! Each regressor is a handful of probes: turns, travels and drifts in proportion to functions of
//! something that a step tells. They go through the same filter as the effects, so that what is tested
//! is what they would do to the track. Of those that show, the strongest is taken in, and the rest is
//! tested again, so that what merely resembles it is not named too.

use crate::effect::composition::{PlacedTerm, Term};
use crate::effect::definition::Effect;
use crate::estimation::fit::Fitted;
use crate::estimation::normal_equations::CampaignEquations;
use crate::numeric::distributions::{chi_squared, false_discovery_rates};
use crate::recording::campaign::Prepared;
use crate::residuals::heavy_tails::unevenness;
use crate::residuals::ripple::ripple;
use crate::selection::effect_test::{Hypothesis, run_scatter_in_the_mean, scatter, test_effect};

use super::floor_location::{PlaceSeen, Suspected, suspected};
use super::probe::{OF_A_RUN, PROBES};
use super::regressor::Regressor;

/// Regressors are to be named falsely at most this often.
const FALSE_DISCOVERY_RATE: f64 = 0.01;

/// From so many runs on a few of them may have something that the others do not have.
const MANY_RUNS: usize = 8;

/// What is left depends on all sorts of things a little; these are the most that are named.
const DEPENDS_ON_MAX: usize = 4;

/// What is in one place may take several functions to say, and is named once.
const ROUNDS_MAX: usize = 8;

/// By chance there is a ripple this seldom.
const RIPPLE_P: f64 = 1e-4;

/// What the residuals depend on, if on anything.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unexplained {
    /// Whether anything is left.
    pub structure: bool,
    /// The regressors that it depends on, strongest first.
    pub depends_on: Vec<Regressor>,
    /// By chance at least this much, of the strongest regressor, corrected for how many were asked.
    pub p_value: f64,
    /// Where on the floor, if it depends on a place and one place says it \[m\].
    pub place_m: Option<[f64; 2]>,
    /// The places of the floor that several runs came to, if one is named.
    pub places: Vec<PlaceSeen>,
}

/// Tests what the model leaves against every regressor, and whether its noise depends on the motion.
pub(crate) fn unexplained(prepared: &Prepared, fitted: &Fitted<'_>) -> Unexplained {
    let mut found = of_regressors(prepared, fitted);
    let p_value = ripple(prepared, fitted);
    if p_value < RIPPLE_P {
        if !found.structure {
            found.p_value = p_value;
        }
        found.structure = true;
        // Whatever else is found may be where its crests happened to stop.
        found.depends_on.retain(|it| *it != Regressor::WheelAngle);
        found.depends_on.insert(0, Regressor::WheelAngle);
    }
    let Some(uneven) = unevenness(prepared, fitted) else { return found };
    if !found.structure || uneven.rules {
        found.p_value = uneven.p_value;
    }
    found.structure = true;
    found.depends_on.retain(|it| *it != uneven.regressor);
    let place = if uneven.rules { 0 } else { found.depends_on.len() };
    found.depends_on.insert(place, uneven.regressor);
    found
}

/// Something that what is left may depend on.
struct Asked<'a> {
    regressor: Regressor,
    effect: &'a dyn Effect,
    /// Its columns, as far as the campaign's motion shows them.
    columns: Vec<usize>,
    /// Which place, if it is one of many.
    spot_m: Option<[f64; 2]>,
}

impl Asked<'_> {
    /// What is the same throughout a run is judged by what runs have for themselves.
    fn is_of_runs(&self) -> bool {
        self.regressor.is_of_runs()
    }
}

/// What speaks for one of those.
#[derive(Clone, Copy)]
struct Finding {
    /// Which of the open ones.
    index: usize,
    p_value: f64,
    /// How much it tells about runs that it was not fitted to.
    merit: f64,
}

/// Tests what the model leaves against every regressor.
fn of_regressors(prepared: &Prepared, fitted: &Fitted<'_>) -> Unexplained {
    let Suspected { spots, looked_at, seen } = suspected(prepared, fitted);
    let mut terms = fitted.terms.clone();
    let in_model = terms.len();
    let probes = PROBES.iter().map(|it| it as &dyn Effect);
    let asked = probes.chain(spots.iter().map(|it| it as &dyn Effect)).chain([&OF_A_RUN as _]);
    terms.extend(asked.map(|effect| {
        let values = vec![0.0; effect.facts().parameters.len()];
        Term::new(effect, values)
    }));
    let terms = PlacedTerm::place(&terms);
    let equations = CampaignEquations::gather(prepared, &terms, &fitted.noise);
    let columns = |term: &PlacedTerm<'_>| term.columns().collect::<Vec<usize>>();
    let mut model: Vec<usize> = terms[..in_model].iter().flat_map(columns).collect();
    let own: Vec<usize> = terms.last().map(columns).unwrap_or_default();
    let regressors =
        PROBES.iter().map(|it| it.regressor).chain(spots.iter().map(|_| Regressor::Place));
    let mut open: Vec<Asked<'_>> = regressors
        .zip(&terms[in_model..])
        .enumerate()
        .map(|(index, (regressor, term))| Asked {
            regressor,
            effect: term.effect,
            columns: visible(&equations, &columns(term)),
            spot_m: index.checked_sub(PROBES.len()).map(|it| spots[it].at_m),
        })
        .filter(|it| !it.columns.is_empty())
        .collect();
    let mut found = Unexplained { p_value: 1.0, ..Unexplained::default() };
    let is_wave = |it: &&Asked<'_>| it.regressor == Regressor::WheelAngle;
    let waves: Vec<Vec<usize>> = open.iter().filter(is_wave).map(|it| it.columns.clone()).collect();
    let many = prepared.runs.len() >= MANY_RUNS;
    let mut within = 1.0;
    for _ in 0..ROUNDS_MAX {
        if open.is_empty() || found.depends_on.len() == DEPENDS_ON_MAX {
            break;
        }
        // A place is no measure of how much runs disagree: many see most of them hardly.
        let usual = open.iter().filter(|it| it.spot_m.is_none());
        within = scatter(&equations, usual.map(|it| (&model[..], &it.columns[..])));
        let between = within.max(run_scatter_in_the_mean(&equations, &model, &own));
        let findings = findings(&equations, &model, &open, (within, between), many, looked_at);
        let rates =
            false_discovery_rates(&findings.iter().map(|it| it.p_value).collect::<Vec<_>>());
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
        let taken = open.remove(best.index);
        found.structure = true;
        if !found.depends_on.contains(&taken.regressor) {
            found.depends_on.push(taken.regressor);
        }
        found.place_m = found.place_m.or(taken.spot_m);
        model.extend(taken.columns);
    }
    if found.place_m.is_some() {
        found.places = seen;
    }
    if counts_start_anew(prepared) && !found.depends_on.contains(&Regressor::WheelAngle) {
        let p_value = waves
            .iter()
            .map(|asked| each_run_by_itself(&equations, (&model, asked), within))
            .fold(1.0, f64::min);
        if p_value < RIPPLE_P {
            if !found.structure {
                found.p_value = p_value;
            }
            found.structure = true;
            found.depends_on.push(Regressor::WheelAngle);
        }
    }
    found
}

/// What speaks for each of these, of all places for the best one alone.
fn findings(
    equations: &CampaignEquations,
    model: &[usize],
    open: &[Asked<'_>],
    (within, between): (f64, f64),
    many: bool,
    looked_at: usize,
) -> Vec<Finding> {
    let finding = |(index, asked): (usize, &Asked<'_>)| {
        let scatter = if asked.is_of_runs() { between } else { within };
        let hypothesis = Hypothesis { model, asked: &asked.columns, effect: asked.effect, scatter };
        let it = test_effect(equations, &hypothesis);
        // A flag says that something is there, not what it is: among many runs a few may raise it.
        let p_value = if many && !asked.is_of_runs() { it.p_value_of_many } else { it.p_value };
        // One run alone does not tell what is in a place from what happened to it there.
        let counts = it.cross_validated_gain > 0.0 && (asked.spot_m.is_none() || it.touched > 1);
        let p_value = if counts { p_value } else { 1.0 };
        Finding { index, p_value, merit: it.cross_validated_gain / it.dispersion }
    };
    let all: Vec<Finding> = open.iter().enumerate().map(finding).collect();
    let (spots, mut rest): (Vec<_>, Vec<_>) =
        all.into_iter().partition(|it| open[it.index].spot_m.is_some());
    // Bonferroni: the best of so many.
    rest.extend(
        spots
            .into_iter()
            .max_by(|a, b| a.merit.total_cmp(&b.merit))
            .map(|it| Finding { p_value: (it.p_value * looked_at as f64).min(1.0), ..it }),
    );
    rest
}

/// Whether the counts begin at the same number in every run: a wheel's angle is then not known across runs.
pub(crate) fn counts_start_anew(prepared: &Prepared) -> bool {
    let mut starts = prepared.runs.iter().filter_map(|run| run.motion.steps.first());
    let Some(first) = starts.next() else { return false };
    let mut others = starts.peekable();
    others.peek().is_some() && others.all(|it| it.phi_rad == first.phi_rad)
}

/// By chance as much gain as these columns have where every run may have its own values of them: what the
/// median run gains, so that most of them have to.
fn each_run_by_itself(
    equations: &CampaignEquations,
    (model, asked): (&[usize], &[usize]),
    scatter: f64,
) -> f64 {
    if asked.is_empty() {
        return 1.0;
    }
    let best = equations.solve(&equations.total, model).delta;
    let mut gains: Vec<f64> = equations
        .units
        .iter()
        .map(|unit| {
            let mut sums = unit.sums.clone();
            for (column, delta) in model.iter().zip(&best) {
                sums.right -= sums.gram.column(*column) * *delta;
            }
            let delta = equations.solve(&sums, asked).delta;
            sums.squares = 0.0;
            -sums.chi_squared(asked, &delta)
        })
        .collect();
    gains.sort_by(f64::total_cmp);
    // Half of the runs gain more than the median does: binomially many of chi^2.
    let median = gains[gains.len() / 2];
    let alone = chi_squared(asked.len(), median / scatter);
    at_least_half(gains.len(), alone)
}

/// Probability that at least half of n independent things happen that each have this probability, at most.
fn at_least_half(n: usize, alone: f64) -> f64 {
    // C(n, k) < 2^n.
    let half = n.div_ceil(2) as f64;
    (2.0_f64.powi(n as i32) * alone.powf(half)).min(1.0)
}

/// Those of the columns that the campaign's motion shows at all.
fn visible(equations: &CampaignEquations, columns: &[usize]) -> Vec<usize> {
    // One sigma at the widest value that a probe can have: anything that is there is far above it.
    columns.iter().copied().filter(|it| equations.total.gram[(*it, *it)] > 1.0).collect()
}
