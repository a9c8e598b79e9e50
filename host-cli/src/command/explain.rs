//! `beeline explain`

use robot_model::compare::Comparer;
use robot_model::explain::explain_given;

use super::compare::{read, warn_if_single_run};
use crate::cli::{Common, ExplainArgs};
use crate::error::{Error, Result};
use crate::explain::{Subject, assumed, headline, reached_again, show};
use crate::ui::say;
use crate::{json, words};
use campaign::model::ModelFile;

pub(super) fn run(common: &Common, args: &ExplainArgs) -> Result<()> {
    let (read, campaign) = read(&args.campaign)?;
    warn_if_single_run(&campaign);
    let model = ModelFile::read_or_empty(&ModelFile::place(&args.campaign))?;
    let catalogue = model.catalogue();
    let in_model: Vec<&str> = model.chosen().iter().map(|effect| effect.facts().id).collect();
    let mut answer = explain_given(&campaign, &catalogue, &in_model).map_err(Error::new)?;
    if let Some(tolerance) = args.tolerance {
        answer = answer.with_tolerance(tolerance.m);
    }
    let mut subject = Subject {
        robot: &read.robot.name,
        campaign: &args.campaign.to_string_lossy(),
        reached: &reached_again(common, &read),
        runs: campaign.fitted_runs().count(),
        catalogue: &catalogue,
        combinations: &[],
        in_model: &model.effects,
        nominal_m: [read.robot.wheel_radius_m, read.robot.track_width_m],
    };
    if common.json || args.format.is_json() {
        say(json::answer(&answer, &headline(&answer, &subject)));
    } else {
        let combinations: Vec<Option<String>> = if answer.steps.is_empty() {
            Vec::new()
        } else {
            let comparer =
                Comparer::with_noise(&campaign, robot_model::recording::OdometryNoise::TYPICAL)
                    .map_err(Error::new)?;
            assumed(&answer.steps, &catalogue)
                .iter()
                .map(|assumed| comparer.net_change(assumed).as_ref().map(words::net_change))
                .collect()
        };
        subject.combinations = &combinations;
        show(&answer, &subject);
    }
    let missing = answer.steps.iter().any(|step| step.matters) || answer.unexplained.structure;
    if args.exit_code && missing { Err(Error::answered_no()) } else { Ok(()) }
}
