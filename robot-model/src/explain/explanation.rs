//! Which effects are missing, in order of evidence?
//!
//! This puts together what selection, residuals and the plan of the next run find; it tests nothing itself.

use crate::clocks;
use crate::effect::catalogue::CATALOGUE;
use crate::effect::composition::{PlacedTerm, Term};
use crate::effect::definition::{ActsOn, Effect, Facts, Need};
use crate::estimation::errors::{ErrorPair, Errors, cross_validated, errors_on_runs};
use crate::estimation::fit::{Fitted, fit_parameters};
use crate::estimation::normal_equations::CampaignEquations;
use crate::estimation::profile_likelihood::interval;
use crate::explain::answer::{Answer, ParameterFound, Reason, Rejected, StepFound, Why};
use crate::explain::held_out;
use crate::explain::next_run::next_run;
use crate::explain::second_opinion::second_opinion;
use crate::numeric::distributions::SIGMAS_95_ROUNDED;
use crate::recording::campaign::{Campaign, Prepared, PreparedRun};
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::run::{RecordingError, RecordingProblem};
use crate::residuals::expression::expression;
use crate::residuals::flexible::{Flexible, displacement_m, flexible};
use crate::residuals::unexplained::{counts_start_anew, unexplained};
use crate::selection::candidates::{Candidate, Screening};
use crate::selection::classes::{Class, classes};
use crate::selection::effect_test::{EffectTest, OWN_SHARE_MIN};
use crate::selection::select::{Selection, is_chance, select, settled};

/// Explains a campaign with the effects of the catalogue.
pub fn explain(campaign: &Campaign) -> Result<Answer, RecordingError> {
    explain_with(campaign, &CATALOGUE)
}

/// Explains a campaign with these effects.
pub fn explain_with(
    campaign: &Campaign,
    catalogue: &[&dyn Effect],
) -> Result<Answer, RecordingError> {
    explain_given(campaign, catalogue, &[])
}

/// Explains what a model with the effects of these ids leaves unexplained. They are fitted again together
/// with whatever is found, and count as known, not as missing.
pub fn explain_given(
    campaign: &Campaign,
    catalogue: &[&dyn Effect],
    in_model: &[&str],
) -> Result<Answer, RecordingError> {
    if campaign.runs.is_empty() {
        let problem = RecordingProblem::NoRuns;
        return Err(RecordingError { run: "1".to_owned(), problem });
    }
    let (prepared, clocks) = clocks::prepare(campaign)?;
    let (prepared, mut selection, flexible) = beyond_noise(prepared, catalogue);
    let opinion = second_opinion(&prepared, &selection.fitted, catalogue);
    let choice = selection.fitted.clone();
    if let Some(opinion) = &opinion {
        // Tests and classes go by the estimated noise; values and errors by the better weights.
        let fitted = Fitted { noise: choice.noise, ..opinion.fitted.clone() };
        let screening = Screening::new(&prepared, &fitted, catalogue);
        selection = Selection::new(fitted, screening);
    }
    let mut found = classes_of(&prepared, &selection);
    if let Some(replaced) = with_known(&prepared, catalogue, (&selection, &found), in_model) {
        selection = replaced;
        found = classes_of(&prepared, &selection);
    }
    let weights = opinion.as_ref().map_or(selection.fitted.noise, |opinion| opinion.fitted.noise);
    let (Selection { fitted, kept, rejected, screening }, classes) = (selection, found);
    let is_known = |index: &usize| {
        let rivals = classes[*index].rivals.iter().map(Candidate::id);
        let own = fitted.terms[*index].effect.facts().id;
        core::iter::once(own).chain(rivals).any(|id| in_model.contains(&id))
    };
    let (known, missing): (Vec<usize>, Vec<usize>) =
        by_evidence(&screening, &kept).into_iter().partition(is_known);
    let sizes_m = screening.sizes_m(&prepared);
    let mut prefix: Vec<Term<'_>> =
        known.iter().map(|index| fitted.terms[*index].clone()).collect();
    let baseline = errors(&prepared, &weights, &prefix);
    let before = fit_parameters(&prepared, prefix.clone(), weights).terms;
    let known: Vec<StepFound> = known
        .into_iter()
        .map(|index| {
            step(
                &prepared,
                &fitted,
                index,
                &kept[index],
                &classes[index],
                (baseline, sizes_m[index]),
            )
        })
        .collect();
    let mut steps = Vec::new();
    for index in missing {
        prefix.push(fitted.terms[index].clone());
        let after = errors(&prepared, &weights, &prefix);
        steps.push(step(
            &prepared,
            &fitted,
            index,
            &kept[index],
            &classes[index],
            (after, sizes_m[index]),
        ));
    }
    let named: Vec<String> =
        known.iter().chain(&steps).flat_map(|step| step.class.clone()).collect();
    let in_model = |id: &str| fitted.terms.iter().any(|term| term.effect.facts().id == id);
    let spoils: Vec<&str> =
        choice.terms.iter().map(|term| term.effect.facts().id).filter(|id| !in_model(id)).collect();
    let rejected = rejected
        .iter()
        .filter(|candidate| !named.iter().any(|name| name == candidate.id()))
        .map(|candidate| match spoils.contains(&candidate.id()) {
            true => Rejected {
                reason: Reason::SimplerPredictsBetter,
                ..reject(&prepared, &fitted, &screening, candidate)
            },
            false => reject(&prepared, &fitted, &screening, candidate),
        })
        .collect();
    let excess = flexible.excess(prepared.robot.track_width_m);
    let mut unexplained = unexplained(&prepared, &choice);
    if excess > EXCESS_MAX && opinion.is_none() {
        unexplained.expression = expression(&prepared, &fitted, &flexible);
    }
    if excess > EXCESS_MAX {
        unexplained.structure = true;
        for regressor in flexible.depends_on.iter().flatten() {
            if !unexplained.depends_on.contains(regressor) {
                unexplained.depends_on.push(*regressor);
            }
        }
    }
    let floor = match &opinion {
        Some(opinion) => lower(&flexible.floor, &opinion.errors, &prepared),
        None => flexible.floor,
    };
    let after = steps.last().map_or(baseline.cross_validated, |step| step.cross_validated);
    let square = |errors: &Errors| errors.position_rms_m.powi(2);
    unexplained.size_m = (square(&after) - square(&floor)).max(0.0).sqrt();
    let answer = Answer {
        known,
        baseline,
        steps,
        rejected,
        unexplained,
        next_run: next_run(&prepared, &fitted, &classes, &kept),
        held_out: held_out::errors(&prepared, &before, &fitted.terms, &fitted.noise),
        floor,
        second_opinion: opinion.map(|opinion| opinion.geometry_only),
        clocks,
        tolerance_m: 0.0,
    };
    let noise = choice.noise.of_one_pose(prepared.poses_in_one);
    let pose_m = noise.position_sigma_m.hypot(noise.position_wobble_m);
    Ok(answer.with_tolerance(TOLERANCE * pose_m))
}

/// The lower of two floors.
fn lower(one: &Errors, other: &Errors, prepared: &Prepared) -> Errors {
    let track_width_m = prepared.robot.track_width_m;
    let lower = displacement_m(other, track_width_m) < displacement_m(one, track_width_m);
    if lower { *other } else { *one }
}

/// What is left of a model, relative to the floor, that must not go without a word.
const EXCESS_MAX: f64 = 1.2;

/// What moves the robot by less than this share of the noise of one pose is not worth correcting.
const TOLERANCE: f64 = 0.1;

/// Less noise than this share of what was learnt is worth another search.
const LESS_NOISE: f64 = 0.9;

/// The effects of a campaign, chosen by noise that is noise, and what a flexible model reaches beside them.
///
/// Noise is learnt from residuals, so what no effect explains passes for noise and hides effects that are there. The
/// flexible model takes up whatever repeats; if it leaves less noise, the search is made again with that. The outcome
/// stands if it comes near the floor: with little noise, something that the catalogue lacks is imitated by many effects.
fn beyond_noise<'a>(
    prepared: Prepared,
    catalogue: &[&'a dyn Effect],
) -> (Prepared, Selection<'a>, Flexible) {
    let selection = select(&prepared, catalogue);
    let first = flexible(&prepared, &selection.fitted, catalogue);
    if first.excess(prepared.robot.track_width_m) < 1.0 / LESS_NOISE {
        return (prepared, selection, first);
    }
    let honest = Prepared { noise: Some(first.noise), ..prepared.clone() };
    let again = select(&honest, catalogue);
    let second = flexible(&honest, &again.fitted, catalogue);
    let track_width_m = prepared.robot.track_width_m;
    if second.excess(track_width_m) < EXCESS_MAX.min(first.excess(track_width_m)) {
        (honest, again, second)
    } else {
        (prepared, selection, first)
    }
}

fn classes_of<'a>(prepared: &Prepared, selection: &Selection<'a>) -> Vec<Class<'a>> {
    classes(prepared, &selection.fitted, &selection.screening, &selection.kept)
}

/// The selection with each effect replaced by a rival that the model has already, if there is one and all
/// of these pass the tests. Otherwise a known effect would be named as its rival, and the values of all others
/// would jump from one campaign to the next.
fn with_known<'a>(
    prepared: &Prepared,
    catalogue: &[&'a dyn Effect],
    (selection, classes): (&Selection<'a>, &[Class<'a>]),
    in_model: &[&str],
) -> Option<Selection<'a>> {
    let mut terms = selection.fitted.terms.clone();
    let mut changed = false;
    for (index, class) in classes.iter().enumerate() {
        let has = |id: &str| terms.iter().any(|term| term.effect.facts().id == id);
        let is_known = |rival: &&Candidate<'a>| in_model.contains(&rival.id()) && !has(rival.id());
        let known = class.rivals.iter().find(is_known);
        if let Some(known) = known
            && !in_model.contains(&terms[index].effect.facts().id)
        {
            terms[index] = known.term.fixed();
            changed = true;
        }
    }
    if !changed {
        return None;
    }
    // Effects that were needed only beside the rival are dropped. If a known one is, the rival was right.
    let is_known = |term: &&Term<'a>| in_model.contains(&term.effect.facts().id);
    let known = terms.iter().filter(is_known).count();
    let settled = settled(prepared, catalogue, terms);
    (settled.fitted.terms.iter().filter(is_known).count() == known).then_some(settled)
}

/// The effects of the model: each next one explains most, given those before.
fn by_evidence(screening: &Screening<'_>, kept: &[EffectTest]) -> Vec<usize> {
    let mut left: Vec<usize> = (0..kept.len()).collect();
    let mut order = Vec::new();
    while !left.is_empty() {
        let cost_with = |index: usize| {
            let others: Vec<usize> = left.iter().copied().filter(|other| *other != index).collect();
            screening.cost_without(&others)
        };
        let costs: Vec<f64> = left.iter().map(|index| cost_with(*index)).collect();
        let best =
            (0..left.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).expect("some are left");
        order.push(left.remove(best));
    }
    order
}

/// The errors of a model of these terms, fitted with this noise.
pub(crate) fn errors(prepared: &Prepared, noise: &OdometryNoise, terms: &[Term<'_>]) -> ErrorPair {
    let terms = fit_parameters(prepared, terms.to_vec(), *noise).terms;
    let terms = PlacedTerm::place(&terms);
    let equations = CampaignEquations::gather(prepared, &terms, noise);
    let columns: Vec<usize> = (0..equations.priors.len()).collect();
    let model = (&equations, terms.as_slice());
    ErrorPair {
        fitted: errors_on_runs(prepared, model, &columns, noise),
        cross_validated: cross_validated(prepared, model, &columns, noise),
    }
}

fn step(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    index: usize,
    test: &EffectTest,
    class: &Class<'_>,
    (after, size_m): (ErrorPair, f64),
) -> StepFound {
    let term = &fitted.terms[index];
    let facts = term.effect.facts();
    let parameters = parameters(prepared, fitted, index, test.dispersion);
    let mut members = vec![facts.id.to_owned()];
    members.extend(class.rivals.iter().map(|rival| rival.id().to_owned()));
    let why = Why {
        signature: facts.signature.to_owned(),
        gain: test.cross_validated_gain,
        one_run_alone: test.one_run_alone,
    };
    StepFound {
        effect: facts.id.to_owned(),
        class: members,
        parameters,
        fitted: after.fitted,
        cross_validated: after.cross_validated,
        p_value: test.p_value,
        why,
        effect_size_m: size_m,
        moves_no_track: facts.acts_on == ActsOn::Gyro,
        matters: true,
    }
}

/// The parameters of one effect of a model. `dispersion`, the variance among runs over what their noise
/// explains, widens the intervals.
pub(crate) fn parameters(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    index: usize,
    dispersion: f64,
) -> Vec<ParameterFound> {
    let term = &fitted.terms[index];
    let first: usize = fitted.terms[..index].iter().map(|term| term.values.len()).sum();
    let parameters = term.effect.facts().parameters.iter().zip(&term.values).enumerate();
    let jackknifed = jackknife(prepared, fitted);
    parameters
        .map(|(j, (parameter, value))| {
            let own = fitted.covariance[(first + j, first + j)].sqrt();
            let ratio = if own > 0.0 { jackknifed[first + j] / (own * own) } else { 0.0 };
            let dispersion = dispersion.max(ratio);
            let sigma = dispersion.sqrt() * own;
            let (low95, high95) = if term.effect.is_linear() {
                (value - SIGMAS_95_ROUNDED * sigma, value + SIGMAS_95_ROUNDED * sigma)
            } else {
                interval(prepared, fitted, (index, j), (own, dispersion))
            };
            ParameterFound {
                name: parameter.name.to_string(),
                unit: parameter.unit.to_string(),
                value: *value,
                sigma,
                low95,
                high95,
            }
        })
        .collect()
}

fn reject(
    prepared: &Prepared,
    fitted: &Fitted<'_>,
    screening: &Screening<'_>,
    candidate: &Candidate<'_>,
) -> Rejected {
    let test = &candidate.test;
    let (equations, terms) = screening.equations();
    let mut columns = screening.model_columns(&[]);
    let own = candidate.term.amplitudes();
    // Over its whole plausible range it does less than one sigma: these runs cannot show it.
    let is_silent =
        |i: &usize| equations.total.gram[(*i, *i)] * equations.priors[*i].spread.powi(2) < 1.0;
    let silent = own.iter().all(is_silent);
    columns.extend(&own);
    let others = &terms[..fitted.terms.len()];
    let with: Vec<PlacedTerm<'_>> = others.iter().chain([&candidate.term]).cloned().collect();
    let facts = candidate.term.effect.facts();
    let (gain, p_value) = (test.cross_validated_gain, test.p_value);
    let reason = if let Some(need) = lacking(prepared, &facts) {
        Reason::Lacking(need)
    } else if silent {
        Reason::NotShown { shown_by: facts.shown_by.to_owned() }
    } else if test.implausible {
        Reason::Implausible { value: test.values[0] }
    } else if let Some((kind, loss)) = test.worse_kind {
        Reason::WorseKind { kind, loss: -loss }
    } else if test.own_share <= OWN_SHARE_MIN {
        Reason::InModel
    } else if gain <= 0.0 && test.one_run_alone {
        Reason::OneRunByChance { gain }
    } else if gain <= 0.0 {
        Reason::PredictsWorse { loss: -gain }
    } else if !test.most_agree() {
        Reason::FewGetBetter { touched: test.touched, better: test.better }
    } else if test.dispersion > 3.0 {
        Reason::RunsDisagree { times: test.dispersion, p_value }
    } else if is_chance(test, screening.asked(), fitted.terms.len() + 1) {
        Reason::Chance { tested: screening.asked(), p_value }
    } else if screening.tracks_get_worse(prepared, &[], &candidate.term) {
        Reason::TracksNoBetter { p_value }
    } else {
        Reason::DoesNotHold { p_value }
    };
    Rejected {
        effect: candidate.id().to_owned(),
        reason,
        cross_validated: cross_validated(prepared, (equations, &with), &columns, &fitted.noise),
    }
}

/// What these runs lack to show an effect.
pub(crate) fn lacking(prepared: &Prepared, facts: &Facts<'_>) -> Option<Need> {
    let runs = &prepared.runs;
    let none = |has: fn(&PreparedRun) -> bool| !runs.iter().any(has);
    let lacks = |need: &Need| match need {
        Need::YawRate => none(|run| run.recording.gyro.len() > 1),
        Need::StartTimes => runs.iter().any(|run| run.recording.started_s.is_none()),
        Need::ContinuousCounts => counts_start_anew(prepared),
        Need::Load => none(|run| run.recording.payload_kg != 0.0),
    };
    facts.needs.iter().copied().find(lacks)
}

/// The variance of each parameter by how it changes when a run is left out: whatever the noise is like, runs vary by
/// themselves.
fn jackknife(prepared: &Prepared, fitted: &Fitted<'_>) -> Vec<f64> {
    let terms = PlacedTerm::place(&fitted.terms);
    let equations = CampaignEquations::gather(prepared, &terms, &fitted.noise);
    let columns: Vec<usize> = (0..equations.priors.len()).collect();
    let runs: Vec<usize> = (0..prepared.runs.len()).collect();
    let n = runs.len() as f64;
    if n < RUNS_FOR_JACKKNIFE {
        return vec![0.0; columns.len()];
    }
    let left_out = |run: &usize| {
        let sums = equations.without(|_, unit| unit.run == *run);
        equations.solve(&sums, &columns).delta
    };
    let each: Vec<_> = runs.iter().map(left_out).collect();
    let variance = |column: &usize| {
        let mean = each.iter().map(|delta| delta[*column]).sum::<f64>() / n;
        each.iter().map(|delta| (delta[*column] - mean).powi(2)).sum::<f64>() * (n - 1.0) / n
    };
    columns.iter().map(variance).collect()
}

/// With fewer runs than this, how they vary is not known.
const RUNS_FOR_JACKKNIFE: f64 = 6.0;
