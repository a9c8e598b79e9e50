//! `beeline compare --drivetrain` and `beeline explain --drivetrain`.

use std::path::Path;

use campaign::motor_model::MotorModelFile;
use campaign::{Campaign, Experiments};
use robot_model::drivetrain::{
    BaselineErrors, EXPERIMENTS_MIN, Experiment, MissingError, MotorAnswer, baseline_errors,
    fit_chosen, missing_with,
};

use crate::error::{Error, Result};
use crate::json;
use crate::motor_page;
use crate::motors::{millimetres, show_answer, show_comparison, verdict};
use crate::ui::{say, warn};

pub(super) fn compare(folder: &Path, as_json: bool) -> Result<()> {
    let (_, found, experiments) = read(folder)?;
    let effects = MotorModelFile::read_or_empty(&MotorModelFile::place(folder))?.chosen();
    let errors = match effects.as_slice() {
        [] => baseline_errors(&found.robot, &experiments),
        effects => fit_chosen(&found.robot, &experiments, effects).map(BaselineErrors::from),
    };
    let errors = errors.map_err(in_words)?;
    let effects: Vec<&str> = effects.iter().map(|effect| effect.facts().id).collect();
    let fitted = found.runs.iter().filter(|run| !run.experiment.held_out);
    let names: Vec<&str> = fitted.map(|run| run.name.as_str()).collect();
    if as_json {
        say(json::motor_comparison(&errors, &names, &effects));
    } else {
        show_comparison(&errors, &names, &effects, folder);
    }
    Ok(())
}

pub(super) fn explain(folder: &Path, as_json: bool, exit_code: bool) -> Result<()> {
    let (_, found, experiments) = read(folder)?;
    if !found.has_times && !as_json {
        warn("not every run has its started_s: nothing can be said about changes with time");
    }
    let answer = answer(folder, &found, &experiments)?;
    if as_json {
        say(json::motor_answer(&answer, &verdict(&answer)));
    } else {
        show_answer(&answer);
    }
    let lacks = !answer.steps.is_empty() || answer.unexplained.structure;
    if exit_code && lacks { Err(Error::answered_no()) } else { Ok(()) }
}

/// The page of `report --drivetrain`.
pub(super) fn page(folder: &Path) -> Result<String> {
    let (_, found, experiments) = read(folder)?;
    let answer = answer(folder, &found, &experiments)?;
    let baseline = baseline_errors(&found.robot, &experiments).map_err(in_words)?;
    let name = folder.file_name().map_or("campaign".into(), |name| name.to_string_lossy());
    Ok(motor_page::of_campaign(&name, &found.runs, &baseline, &answer))
}

/// What is missing, of the catalogue and of the user's own effects.
fn answer(folder: &Path, found: &Experiments, experiments: &[Experiment]) -> Result<MotorAnswer> {
    let own = MotorModelFile::read_or_empty(&MotorModelFile::place(folder))?;
    missing_with(&found.robot, experiments, &own.catalogue()).map_err(in_words)
}

/// The robot's name, and its experiments; warns of what is left out.
pub(super) fn read(folder: &Path) -> Result<(String, Experiments, Vec<Experiment>)> {
    let campaign = Campaign::read(folder)?;
    campaign.warnings.iter().for_each(warn);
    let found = campaign.experiments(folder)?;
    if !found.left_out.is_empty() {
        let names = found.left_out.join(", ");
        warn(format_args!("skipped, as there is no voltage or no motion: {names}"));
    }
    let experiments = found.runs.iter().map(|run| run.experiment.clone()).collect();
    Ok((campaign.robot.name, found, experiments))
}

pub(super) fn in_words(error: MissingError) -> Error {
    match error {
        MissingError::TooFew { experiments } => Error::new(format_args!(
            "{experiments} experiments are too few to tell an effect from chance; {EXPERIMENTS_MIN} are the least"
        ))
        .hint("`beeline tune --record FOLDER` drives about fifty"),
        MissingError::NoMotion => Error::new("the wheels hardly turn in these runs")
            .hint("are left_v and right_v volts, and of the same wheels as the counts?"),
        MissingError::Inseparable { effect } => Error::new(format_args!(
            "{effect} does what the rest of the model can do already: these experiments cannot tell them apart"
        ))
        .hint("remove the effect that it is like, or leave it out; kS, kV, kA, kC, kD and kW are always there. Nothing was changed"),
        MissingError::Unstable { effect, before_m, after_m } => {
            let after = if after_m.is_finite() { millimetres(after_m) } else { "any length".into() };
            let before = millimetres(before_m);
            Error::new(format_args!(
                "these experiments do not determine {effect}: with it, each is predicted by the others to {after}, without it to {before}"
            ))
            .hint("leave it out, or, if it is an equation of yours, give its parameters a narrower --range. Nothing was changed")
        }
    }
}
