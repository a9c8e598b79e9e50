//! What a campaign that is continued takes from its folder: its plan, and the facts of its runs.

use std::path::Path;

use crate::error::{Error, Result};
use campaign::file::write_own;
use campaign::plan::{CampaignPlan, PlannedRun, plan_path};
use campaign::{Campaign, CampaignWriter, RunFacts};

/// Writes the plan into the folder; refused if its runs were recorded by another plan.
pub(super) fn keep_plan(folder: &Path, plan: &CampaignPlan, has_runs: bool) -> Result<()> {
    let path = plan_path(folder);
    if has_runs && path.exists() {
        if !CampaignPlan::read(&path)?.drives_the_same_as(plan) {
            return Err(Error::new(format_args!(
                "{} was begun with another plan",
                folder.display()
            ))
            .hint(
                "leave out the plan options to continue its own plan, or choose another folder",
            ));
        }
        return Ok(());
    }
    write_own(&path, plan.to_toml().as_bytes()).map_err(|error| {
        Error::new(format_args!("cannot write {}: {error}", path.display()))
            .hint(error.hint("check the folder"))
    })
}

/// Gives runs of the plan that have no facts in `robot.toml` those of the plan: an older version lost them when it was ended
/// between a run and its facts.
pub(super) fn restore_facts(
    writer: &CampaignWriter,
    there: &Campaign,
    plan: &CampaignPlan,
    restored: &mut dyn FnMut(&str),
) -> Result<()> {
    for (run, name) in there.runs.iter().zip(there.plain_names()) {
        let planned = plan.runs.iter().find(|planned| planned.name == name);
        let facts = planned.map(planned_facts).unwrap_or_default();
        if facts != RunFacts::default() && writer.restore_facts(&run.name, &facts)? {
            restored(&run.name);
        }
    }
    Ok(())
}

/// What a plan says of a run before it is driven.
pub(super) fn planned_facts(run: &PlannedRun) -> RunFacts {
    RunFacts {
        payload_kg: (run.payload_kg > 0.0).then_some(run.payload_kg),
        held_out: run.held_out,
        ..RunFacts::default()
    }
}
