//! What a campaign says while it is recorded: the planned paths, the recorded ones, the error so far, and what `explain` finds.
//!
//! All of it comes from the folder, as for any command that reads a campaign.

use std::path::Path;
use std::time::Duration;

use campaign::Campaign;
use campaign::plan::floor::nominal_path;
use campaign::plan::{CampaignPlan, PlannedRun, plan_path};
use serde_json::{Value, json};

use crate::escape::seen;
use crate::fit_cache::FitCache;
use crate::model_page::{ModelRequest, Workbench};

/// The folder is looked at this often.
const EVERY: Duration = Duration::from_millis(300);

/// With fewer runs, nothing can be told apart.
const EXPLAINED_FROM: usize = 3;

/// Tells what the folder says, again whenever that changes, until the recording `has_ended`.
pub(super) fn follow(folder: &Path, has_ended: impl Fn() -> bool, mut tell: impl FnMut(Value)) {
    let mut known = None;
    loop {
        // Asked first: what is written last is seen as well.
        let ended = has_ended();
        let names = Campaign::read_if_any(folder).ok().flatten().map(|read| read.plain_names());
        let now = Some((names.unwrap_or_default(), plan_path(folder).is_file()));
        if now != known {
            known = now;
            look(folder, &mut tell);
        }
        if ended {
            return;
        }
        std::thread::sleep(EVERY);
    }
}

/// Tells what the folder says: first what costs nothing, then what `explain` finds.
fn look(folder: &Path, tell: &mut dyn FnMut(Value)) {
    let mut so_far = json!({
        "planned": planned(folder),
        "recorded": [],
        "error_m": null,
        "found": [],
        "next": null,
        "next_kind": null,
    });
    let Some((workbench, runs)) = workbench(folder) else { return tell(so_far) };
    let campaign = workbench.campaign();
    // An error of the nominal robot is shown as none: `compare` says what is wrong.
    if let Ok(nominal) = workbench.model_answer(&ModelRequest::default()) {
        let recorded = campaign["runs"].as_array().into_iter().flatten();
        let errors = nominal["runs"].as_array().into_iter().flatten();
        let recorded = recorded.zip(errors).map(|(run, error)| {
            json!({
                "name": run["name"],
                "kind": run["kind"],
                "held_out": run["held_out"],
                "path": run["measured"],
                "error_m": error["rms_m"],
            })
        });
        so_far["recorded"] = recorded.collect();
        so_far["error_m"] = nominal["errors"]["cross_validated"]["position_rms_m"].clone();
    }
    tell(so_far.clone());
    if runs < EXPLAINED_FROM {
        return;
    }
    workbench.explain();
    let explanation = workbench.explanation();
    let answer = &explanation["answer"];
    let verdict = answer["verdict"].as_str().into_iter();
    let found = explanation["found"].as_array().into_iter().flatten();
    so_far["found"] = verdict.map(Value::from).chain(found.cloned()).collect();
    so_far["next"] = answer["next"]["words"].clone();
    so_far["next_kind"] = answer["next_run"]["kind"].clone();
    tell(so_far);
}

/// The campaign as it is by now, if it has a run that can be compared.
fn workbench(folder: &Path) -> Option<(Workbench, usize)> {
    let (read, recordings) = Campaign::read_both(folder).ok()?;
    let campaign = recordings.into_model(&read, folder).ok()?;
    let runs = campaign.fitted_runs().count();
    // The page says itself how a next run is recorded.
    let workbench = Workbench::new(folder, (read, campaign), String::new(), FitCache::none());
    Some((workbench.ok()?, runs))
}

fn planned(folder: &Path) -> Vec<Value> {
    let plan = CampaignPlan::read(&plan_path(folder));
    let to_json = |run: &PlannedRun| {
        json!({
            "name": seen(&run.name),
            "shows": seen(&run.shows),
            "heading_rad": run.heading_rad,
            "held_out": run.held_out,
            "path": path(run),
        })
    };
    plan.map_or_else(|_| Vec::new(), |plan| plan.runs.iter().map(to_json).collect())
}

/// The nominal path in the campaign's frame \[m\], to a millimetre.
fn path(run: &PlannedRun) -> Vec<[f64; 2]> {
    let (sin, cos) = run.heading_rad.sin_cos();
    let round = |metres: f64| (metres * 1e3).round() / 1e3;
    let place = |[x_m, y_m]: [f64; 2]| [round(x_m * cos - y_m * sin), round(x_m * sin + y_m * cos)];
    nominal_path(&run.pieces).into_iter().map(place).collect()
}
