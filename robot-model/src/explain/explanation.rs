//! Which effects are missing, in order of evidence?
//!
//! This puts together what selection, residuals and the plan of the next run find; it tests nothing itself.

use crate::clocks;
use crate::effect::catalogue::CATALOGUE;
use crate::effect::composition::{PlacedTerm, Term};
use crate::effect::definition::{ActsOn, Effect, Facts, Need};
use crate::estimation::errors::{ErrorPair, Errors, cross_validated, displacement_m};
use crate::estimation::fit::{Fitted, fit_parameters, fit_roughly};
use crate::estimation::gyro::heading_turned_rad;
use crate::estimation::tolerance::{least_size_m, tolerance_m};
use crate::explain::answer::{
    Answer, Averaged, Evidence, ParameterFound, Reason, Rejected, StepFound,
};
use crate::explain::held_out;
use crate::explain::model_averaging::{averaged, mean, tell_values};
use crate::explain::model_choice::{Choice, by_evidence, choose};
use crate::explain::model_errors::{errors, errors_as_fitted};
use crate::explain::next_run::next_run;
use crate::explain::parameters::parameters;
use crate::explain::progress::{Observer, Progress};
use crate::explain::reachable_error::reachable_and_unexplained;
use crate::explain::set_aside::without_few;
use crate::explain::used_to_predict::left_out;
use crate::recording::campaign::{Campaign, Prepared, PreparedRun};
use crate::recording::run::{RecordingError, RecordingProblem};
use crate::residuals::unexplained::counts_start_anew;
use crate::selection::candidates::{Candidate, Screening, is_geometry};
use crate::selection::chance::is_chance;
use crate::selection::effect_test::OWN_SHARE_MIN;
use crate::selection::gain::BLUR_MAX;
use crate::selection::select::Selection;
use crate::selection::track_gain::TrackGain;

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
    explain_observed(campaign, catalogue, in_model, None)
}

/// The same, and tells `observer` what was found so far.
///
/// A few runs that are off by far more than the others are left out, where that makes the others predictable
/// ([`Answer::set_aside`]).
pub fn explain_observed(
    campaign: &Campaign,
    catalogue: &[&dyn Effect],
    in_model: &[&str],
    observer: Option<Observer<'_>>,
) -> Result<Answer, RecordingError> {
    let of_all = explain_all(campaign, catalogue, in_model, observer)?;
    let again = |others: &Campaign| explain_all(others, catalogue, in_model, None);
    without_few((campaign, catalogue), of_all, again)
}

/// Explains all of these runs together.
fn explain_all(
    campaign: &Campaign,
    catalogue: &[&dyn Effect],
    in_model: &[&str],
    mut observer: Option<Observer<'_>>,
) -> Result<Answer, RecordingError> {
    if campaign.runs.is_empty() {
        return Err(RecordingError { run: "1".to_owned(), problem: RecordingProblem::NoRuns });
    }
    let (prepared, clocks) = clocks::prepare(campaign)?;
    if let Some(observer) = &mut observer {
        observer(Progress::Clocks(&clocks));
        observer(geometry(&prepared, catalogue));
    }
    let choice = choose(prepared, catalogue, in_model);
    let Choice { prepared, selection, classes, weights, selected, .. } = &choice;
    let Selection { fitted, kept, screening, .. } = selection;
    let (known, missing) = known_and_missing(&choice, in_model);
    let gains = screening.track_gains(prepared);
    let mut prefix: Vec<Term<'_>> = known.iter().map(|i| fitted.terms[*i].clone()).collect();
    let errors_of = |prefix: &[Term<'_>]| errors(prepared, weights, &with_along(&choice, prefix));
    let baseline = errors_of(&prefix);
    let before = fit_parameters(prepared, with_along(&choice, &prefix), *weights).terms;
    let parameters = parameters(prepared, fitted, kept);
    let step_of = |index: usize, after| step(&choice, index, &parameters, (after, &gains[index]));
    let mut known: Vec<StepFound> = known.into_iter().map(|i| step_of(i, baseline)).collect();
    let mut steps = Vec::new();
    for index in missing.iter().copied() {
        prefix.push(fitted.terms[index].clone());
        let step = step_of(index, errors_of(&prefix));
        if let Some(observer) = &mut observer {
            observer(Progress::Effect(&step));
        }
        steps.push(step);
    }
    no_more_than_there_was(&mut steps, &baseline.cross_validated, prepared.robot.track_width_m);
    let (reachable, unexplained) =
        reachable_and_unexplained(&choice, &reached(&baseline, &steps), catalogue);
    let tolerance_m = tolerance_m(prepared, &selected.noise);
    let floor = unexplained.structure.then_some(&reachable);
    let left_out = left_out(&choice, (&missing, &mut steps), (floor, tolerance_m));
    let mean = mean(&choice, &left_out);
    let predicts_with = averaged(&choice, &parameters, &mean);
    let of_all = steps.last().map_or(baseline, StepFound::errors);
    let predicts_by =
        if left_out.is_empty() { of_all } else { errors(prepared, weights, mean.of_choice()) };
    if !left_out.is_empty() {
        tell_values(&choice, &predicts_with, known.iter_mut().chain(&mut steps));
    }
    let answer = Answer {
        rejected: rejected(&choice, known.iter().chain(&steps)),
        known,
        baseline,
        steps,
        fitted_along: fitted_along(&choice, &predicts_with),
        unexplained,
        next_run: next_run(prepared, fitted, classes, kept),
        held_out: held_out::errors(prepared, &before, &mean.terms, &fitted.noise),
        reachable,
        alternative_fit: choice.alternative.as_ref().map(|fit| fit.geometry_only),
        clocks,
        tolerance_m: 0.0,
        predicts_with,
        predicts_by,
        noise: *weights,
        compared_by: choice.first_noise.of_one_pose(prepared.poses_in_one),
        set_aside: None,
    };
    Ok(answer.with_tolerance(tolerance_m))
}

/// The effects found, in order of evidence: those that the user's model has, and the others.
fn known_and_missing(choice: &Choice<'_>, in_model: &[&str]) -> (Vec<usize>, Vec<usize>) {
    let Choice { prepared, selection, classes, .. } = choice;
    let is_known = |index: &usize| {
        let rivals = classes[*index].rivals.iter().map(Candidate::id);
        let own = selection.fitted.terms[*index].effect.facts().id;
        core::iter::once(own).chain(rivals).any(|id| in_model.contains(&id))
    };
    let found = by_evidence(prepared, &selection.screening, &selection.kept).into_iter();
    found.filter(|index| !choice.along.contains(index)).partition(is_known)
}

/// Cross-validated errors before the first step, and after each.
fn reached(baseline: &ErrorPair, steps: &[StepFound]) -> Vec<Errors> {
    let after = steps.iter().map(|step| step.cross_validated);
    core::iter::once(baseline.cross_validated).chain(after).collect()
}

/// Of a model that predicts other runs, the radii and track width that are no finding of their own.
fn fitted_along(choice: &Choice<'_>, predicts_with: &[Averaged]) -> Vec<Averaged> {
    let id = |index: &usize| choice.selection.fitted.terms[*index].effect.facts().id;
    let along: Vec<&str> = choice.along.iter().map(id).collect();
    predicts_with.iter().filter(|one| along.contains(&&*one.effect)).cloned().collect()
}

/// These terms, with the radii and track width that are fitted along if any of these is of radii or track width.
fn with_along<'a>(choice: &Choice<'a>, terms: &[Term<'a>]) -> Vec<Term<'a>> {
    let mut terms = terms.to_vec();
    if terms.iter().any(|term| is_geometry(term.effect)) {
        terms
            .extend(choice.along.iter().map(|index| choice.selection.fitted.terms[*index].clone()));
    }
    terms
}

/// Holds the sizes of all steps to what they remove together.
///
/// Without one of two effects that nearly cancel, a model is off by more than the robot ever was. To add both removes no
/// more than there was.
pub(super) fn no_more_than_there_was(steps: &mut [StepFound], before: &Errors, track_width_m: f64) {
    let Some(last) = steps.last() else { return };
    let [before_m, after_m] =
        [before, &last.cross_validated].map(|errors| displacement_m(errors, track_width_m));
    let removed_m = (before_m.powi(2) - after_m.powi(2)).max(0.0).sqrt();
    for step in steps.iter_mut().filter(|step| !step.moves_no_track) {
        let share = (removed_m / step.effect_size_m).min(1.0);
        step.effect_size_m = step.effect_size_m.min(removed_m);
        step.least_size_m *= share;
    }
}

/// What the geometry alone explains.
fn geometry(prepared: &Prepared, catalogue: &[&dyn Effect]) -> Progress<'static> {
    let terms = catalogue.iter().filter(|effect| is_geometry(**effect));
    let terms: Vec<Term<'_>> = terms.map(|effect| Term::new(*effect, vec![0.0])).collect();
    let fitted = fit_roughly(prepared, terms);
    let of = |terms: &[Term<'_>]| errors_as_fitted(prepared, &fitted.noise, terms).cross_validated;
    Progress::Geometry { before: of(&[]), after: of(&fitted.terms) }
}

/// What was tested and is not named by any of these steps.
fn rejected<'s>(choice: &Choice<'_>, steps: impl Iterator<Item = &'s StepFound>) -> Vec<Rejected> {
    let Choice { prepared, selection: Selection { fitted, rejected, screening, .. }, .. } = choice;
    let named: Vec<&String> = steps.flat_map(|step| &step.class).collect();
    let has = |terms: &[Term<'_>], id: &str| terms.iter().any(|term| term.effect.facts().id == id);
    rejected
        .iter()
        .filter(|candidate| !named.iter().any(|name| *name == candidate.id()))
        .map(|candidate| {
            let found = reject(prepared, fitted, screening, candidate);
            match has(&choice.selected.terms, candidate.id()) {
                // It was chosen, and a simpler model predicts better.
                true => Rejected { reason: Reason::SimplerPredictsBetter, ..found },
                false => found,
            }
        })
        .collect()
}

fn step(
    choice: &Choice<'_>,
    index: usize,
    parameters: &[Vec<ParameterFound>],
    (after, gain): (ErrorPair, &TrackGain),
) -> StepFound {
    let Choice { prepared, selection, classes, .. } = choice;
    let Selection { fitted, kept, screening, .. } = selection;
    let (test, class) = (&kept[index], &classes[index]);
    let term = &fitted.terms[index];
    let facts = term.effect.facts();
    let mut members = vec![facts.id.to_owned()];
    members.extend(class.rivals.iter().map(|rival| rival.id().to_owned()));
    let evidence = Evidence {
        signature: facts.signature.to_owned(),
        gain: test.cross_validated_gain,
        one_run_alone: test.one_run_alone,
    };
    let moves_no_track = facts.acts_on == ActsOn::Gyro;
    // As far as the wheels of a robot would be off that goes by the sensor's heading.
    let size_m = match moves_no_track {
        true => {
            let turned_rad = heading_turned_rad(&prepared.runs, &fitted.terms, index);
            turned_rad * prepared.robot.track_width_m / 2.0
        }
        false => gain.size_m,
    };
    StepFound {
        effect: facts.id.to_owned(),
        class: members,
        parameters: parameters[index].clone(),
        fitted: after.fitted,
        cross_validated: after.cross_validated,
        p_value: test.p_value,
        evidence,
        effect_size_m: size_m,
        least_size_m: least_size_m(size_m, test.p_value, screening.asked()),
        moves_no_track,
        nears_runs: moves_no_track || gain.nears_runs(&test.shown_by),
        matters: true,
        used_to_predict: true,
    }
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
    } else if test.blurs_geometry >= BLUR_MAX {
        Reason::BlursGeometry { times: test.blurs_geometry }
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
