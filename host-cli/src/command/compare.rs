//! `beeline compare`

use std::path::Path;

use robot_model::compare::Comparer;
use serde_json::json;

use crate::cli::{Common, CompareArgs};
use crate::compare::show;
use crate::error::{Error, Result};
use crate::json;
use crate::ui::{say, warn};
use campaign::Campaign;
use campaign::model::ModelFile;

pub(super) fn run(common: &Common, args: &CompareArgs) -> Result<()> {
    let (_, campaign) = read(&args.campaign)?;
    let default = ModelFile::place(&args.campaign);
    let (file, model) = match &args.model {
        Some(file) => (file, ModelFile::read(file)?),
        None => (&default, ModelFile::read_or_empty(&default)?),
    };
    let assumed = model.assumed().map_err(|id| {
        let campaign = args.campaign.display();
        Error::new(format_args!("{}: {id} has no values yet", file.display()))
            .hint(format_args!("`beeline model fit {campaign}`"))
    })?;
    let own: Vec<_> = model.own().collect();
    let comparer = Comparer::new(&campaign, &own).map_err(Error::new)?;
    let comparison = comparer.compare(&assumed);
    let nominal = (!assumed.is_empty()).then(|| comparer.compare(&[]));
    if common.json || args.format.is_json() {
        let effects: Vec<&str> = assumed.iter().map(|it| it.effect.facts().id).collect();
        say(json!({
            "schema": 1,
            "model": effects,
            "comparison": json::comparison(&comparison),
            "nominal": nominal.as_ref().map(|it| json!({
                "position_m": json::rms(&it.position_m),
                "heading_rad": json::rms(&it.heading_rad),
            })),
        }));
    } else {
        show(&comparison, nominal.as_ref());
    }
    Ok(())
}

/// Names the runs that are skipped.
pub(super) fn warn_of_blind_runs(campaign: &Campaign) {
    let names = campaign.without_poses();
    if !names.is_empty() {
        warn(format_args!("skipped, as no position was measured: {}", names.join(", ")));
    }
}

/// Reads a campaign, says what was skipped, and returns the campaign as read and as the model sees it.
pub(super) fn read(folder: &Path) -> Result<(Campaign, robot_model::recording::Campaign)> {
    let (read, recordings) = Campaign::read_both(folder)?;
    read.warnings.iter().for_each(warn);
    let campaign = recordings.into_model(&read, folder)?;
    warn_of_blind_runs(&read);
    Ok((read, campaign))
}

/// One run is predicted by a fit to itself: its error is not cross-validated.
pub(super) fn warn_if_lone(campaign: &robot_model::recording::Campaign) {
    if campaign.fitted_runs().count() == 1 {
        warn(
            "only one run: nothing can be cross-validated, and the errors are those of the fit to this run; record more runs",
        );
    }
}
