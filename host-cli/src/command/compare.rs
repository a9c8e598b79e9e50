//! `beeline compare`: reads a campaign and a model, and shows how far they differ.
//!
//! The comparison is computed in `robot-model` and put into words by [`crate::compare`].

use std::path::Path;

use robot_model::compare::EffectWithValues;
use serde_json::Value;

use super::motors;
use crate::cli::{Common, CompareArgs};
use crate::compare::show;
use crate::error::{Error, Result};
use crate::escape::shell_path;
use crate::json;
use crate::ui::{Steps, say, warn};
use campaign::Campaign;
use campaign::model::ModelFile;

pub(super) fn run(common: &Common, args: &CompareArgs) -> Result<()> {
    if args.drivetrain {
        return motors::compare(&args.campaign, common.json || args.format.is_json());
    }
    let (_, campaign) = read(&args.campaign)?;
    let default = ModelFile::place(&args.campaign);
    let (file, model) = match &args.model {
        Some(file) => (file, ModelFile::read(file)?),
        None => (&default, ModelFile::read_or_empty(&default)?),
    };
    let model_effects = effects_of(&model, file, &args.campaign)?;
    let cache = args.reuse.cache(common.json);
    let comparer = cache.comparer(&campaign, &model)?;
    let comparison = comparer.compare(&model_effects);
    let nominal = (!model_effects.is_empty()).then(|| comparer.compare(&[]));
    if common.json || args.format.is_json() {
        let effects: Vec<&str> = model_effects.iter().map(|one| one.effect.facts().id).collect();
        say(json::compared(&effects, &comparison, nominal.as_ref()));
    } else {
        show(&comparison, nominal.as_ref());
    }
    Ok(())
}

/// The effects of a model of this file, with their values.
pub(super) fn effects_of<'a>(
    model: &'a ModelFile,
    file: &Path,
    campaign: &Path,
) -> Result<Vec<EffectWithValues<'a>>> {
    model.effects_with_values().map_err(|id| {
        Error::new(format_args!("{}: {id} has no values yet", file.display()))
            .hint(format_args!("`beeline model fit {}`", shell_path(campaign)))
    })
}

/// Warns of runs that are ignored, as they have no measured positions.
pub(super) fn warn_of_runs_without_poses(campaign: &Campaign) {
    let names = campaign.without_poses();
    if !names.is_empty() {
        warn(format_args!("skipped, as no position was measured: {}", names.join(", ")));
    }
}

/// Reads a campaign, prints its warnings, and returns it both as read and as `robot-model` takes
/// it.
pub(super) fn read(folder: &Path) -> Result<(Campaign, robot_model::recording::Campaign)> {
    let (read, campaign, _) = read_and_judge(folder, true)?;
    Ok((read, campaign))
}

/// The same, with what is wrong with the data without keeping a fit from being made, for programs. A terminal shows what is
/// done, unless `quiet`.
pub(super) fn read_and_judge(
    folder: &Path,
    quiet: bool,
) -> Result<(Campaign, robot_model::recording::Campaign, Vec<Value>)> {
    let steps = Steps::new(quiet);
    steps.now("reading and checking the runs");
    let (read, recordings) = Campaign::read_both(folder)?;
    // Nothing is drawn over warnings.
    drop(steps);
    read.warnings.iter().for_each(warn);
    let found = json::data_hypotheses(&read, &recordings, folder);
    let campaign = recordings.into_model(&read, folder)?;
    warn_of_runs_without_poses(&read);
    Ok((read, campaign, found))
}

/// Warns of a campaign with a single run: nothing can be cross-validated, so its errors are those
/// of the fit.
pub(super) fn warn_if_single_run(campaign: &robot_model::recording::Campaign) {
    if campaign.fitted_runs().count() == 1 {
        warn(
            "only one run: nothing can be cross-validated, and the errors are those of the fit to this run; record more runs",
        );
    }
}
