//! What a model predicts of the runs kept aside: the only errors that nothing was fitted to or chosen by.

use crate::effect::composition::{PlacedTerm, Term};
use crate::estimation::errors::{Errors, train};
use crate::estimation::normal_equations::CampaignEquations;
use crate::estimation::odometry_noise::OdometryNoise;
use crate::explain::answer::HeldOut;
use crate::recording::campaign::{Prepared, PreparedRun};
use crate::recording::run_kind::RunKind;

/// Errors before and with these terms, as they are; `None` where no run is kept aside.
pub(crate) fn errors(
    prepared: &Prepared,
    before: &[Term<'_>],
    terms: &[Term<'_>],
    noise: &OdometryNoise,
) -> Option<HeldOut> {
    if prepared.held_out.is_empty() {
        return None;
    }
    let there = only(prepared);
    let errors = |terms: &[Term<'_>]| -> Errors {
        let terms = PlacedTerm::place(terms);
        let equations = CampaignEquations::gather(&there, &terms, noise);
        train(&there, (&equations, &terms), &[], noise)
    };
    let mut kinds: Vec<RunKind> = Vec::new();
    for run in &there.runs {
        if !kinds.contains(&run.kind) {
            kinds.push(run.kind);
        }
    }
    Some(HeldOut { runs: there.runs.len(), kinds, baseline: errors(before), model: errors(terms) })
}

/// The campaign of the runs kept aside alone, in the light of what is known of the others.
pub(crate) fn only(prepared: &Prepared) -> Prepared {
    let runs: Vec<PreparedRun> = prepared.held_out.clone();
    Prepared { robot: prepared.robot, runs, held_out: Vec::new(), survey: prepared.survey }
}
