//! `beeline explain`

use std::path::Path;

use robot_model::compare::Comparer;
use robot_model::effect::Effect;
use robot_model::recording;
use robot_model::recording::OdometryNoise;

use super::compare::{read_and_judge, warn_if_single_run};
use super::motors;
use crate::cli::{Common, ExplainArgs};
use crate::error::{Error, Result};
use crate::explain::{
    AnswerContext, effects_with_values, explained, headline, net_changes, next_run_options, show,
};
use crate::fit_cache::Question;
use crate::json;
use crate::ui::{note, say};
use campaign::Campaign;
use campaign::model::ModelFile;

pub(super) fn run(common: &Common, args: &ExplainArgs) -> Result<()> {
    if args.drivetrain {
        let json = common.json || args.format.is_json();
        return motors::explain(&args.campaign, json, args.exit_code);
    }
    if let Some(file) = &args.save {
        check_new(file)?;
    }
    let (read, campaign, data) = read_and_judge(&args.campaign, common.json)?;
    warn_if_single_run(&campaign);
    let model = ModelFile::read_or_empty(&ModelFile::place(&args.campaign))?;
    let catalogue = model.catalogue();
    let in_model: Vec<&str> = model.chosen().iter().map(|effect| effect.facts().id).collect();
    let cache = args.reuse.cache(common.json);
    let question = Question { campaign: &campaign, catalogue: &catalogue, in_model: &in_model };
    let mut answer = explained(&question, &cache, common.json)?;
    if let Some(tolerance) = args.tolerance {
        answer = answer.with_tolerance(tolerance.m);
    }
    // Before anything is said: whoever reads the first lines only has the file all the same.
    if let Some(file) = &args.save {
        let found = model.found(&answer, campaign.fitted_runs().count());
        if !found.write_new(file, &read.robot.name)? {
            // Somebody else has written it meanwhile.
            check_new(file)?;
        }
    }
    let context = answer_context(common, &args.campaign, (&read, &campaign), &catalogue);
    let context = AnswerContext { in_model: &model.effects, ..context };
    if common.json || args.format.is_json() {
        say(json::answer(&answer, &headline(&answer, &context), &data));
    } else {
        let combinations = if answer.steps.is_empty() {
            Vec::new()
        } else {
            let comparer = Comparer::with_noise(&campaign, OdometryNoise::TYPICAL)?;
            net_changes(&comparer, &effects_with_values(&answer.steps, &catalogue))
        };
        show(&answer, &AnswerContext { combinations, ..context });
    }
    if let Some(file) = &args.save {
        note(format_args!("{}: the model found, to predict other runs with", file.display()));
    }
    let missing = answer.steps.iter().any(|step| step.matters)
        || answer.unexplained.structure
        || answer.set_aside.is_some();
    if args.exit_code && missing { Err(Error::answered_no()) } else { Ok(()) }
}

/// Refuses a file that exists: a model may have been edited by hand.
fn check_new(file: &Path) -> Result<()> {
    match file.exists() {
        true => Err(Error::new(format_args!("{} exists", file.display()))
            .hint("choose another name, or remove that file")),
        false => Ok(()),
    }
}

/// What is asked of the campaign in a folder, with no effect in its model and none found yet.
pub(super) fn answer_context<'a>(
    common: &Common,
    folder: &Path,
    (read, campaign): (&'a Campaign, &recording::Campaign),
    catalogue: &'a [&'a dyn Effect],
) -> AnswerContext<'a> {
    AnswerContext {
        robot: &read.robot.name,
        campaign: folder.to_string_lossy().into_owned(),
        robot_options: next_run_options(common, read),
        runs: campaign.fitted_runs().map(|run| run.name.clone()).collect(),
        motions: campaign.motions(),
        catalogue,
        in_model: &[],
        combinations: Vec::new(),
        nominal_m: [read.robot.wheel_radius_m, read.robot.track_width_m],
    }
}
