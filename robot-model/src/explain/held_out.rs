//! How well does a model predict the held-out runs? Nothing was fitted to them or selected by them.
//!
//! Cross-validated errors, of runs that take part in the fit, are in [`crate::estimation`].

use crate::effect::composition::{PlacedTerm, Term};
use crate::estimation::campaign_equations::CampaignEquations;
use crate::estimation::errors::{Errors, errors_on_runs};
use crate::explain::answer::HeldOut;
use crate::recording::campaign::{Prepared, PreparedRun};
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::run_kind::RunKind;

/// Errors with the terms of `before` and with `terms`, as they are; `None` if no run is held out.
pub(crate) fn errors(
    prepared: &Prepared,
    before: &[Term<'_>],
    terms: &[Term<'_>],
    noise: &OdometryNoise,
) -> Option<HeldOut> {
    if prepared.held_out.is_empty() {
        return None;
    }
    let held_out = only(prepared);
    let errors = |terms: &[Term<'_>]| -> Errors {
        let terms = PlacedTerm::place(terms);
        let equations = CampaignEquations::gather(&held_out, &terms, noise);
        errors_on_runs(&held_out, (&equations, &terms), &[], noise)
    };
    let mut kinds: Vec<RunKind> = Vec::new();
    for run in &held_out.runs {
        if !kinds.contains(&run.kind) {
            kinds.push(run.kind);
        }
    }
    let runs = held_out.runs.len();
    Some(HeldOut { runs, kinds, baseline: errors(before), model: errors(terms) })
}

/// A campaign of the held-out runs only, with the excitation of the others.
pub(crate) fn only(prepared: &Prepared) -> Prepared {
    let runs: Vec<PreparedRun> = prepared.held_out.clone();
    Prepared { runs, held_out: Vec::new(), ..prepared.clone() }
}
