//! What a model predicts of the runs kept aside: the only errors that nothing was fitted to or chosen by.

use crate::answer::{Aside, Errors};
use crate::campaign::{Prepared, PreparedRun};
use crate::errors::train;
use crate::evidence::Evidence;
use crate::increment::Term;
use crate::odometry_noise::OdometryNoise;

/// Errors before and with these terms, as they are; `None` where no run is kept aside.
pub(crate) fn errors(
    prepared: &Prepared,
    before: &[Term<'_>],
    terms: &[Term<'_>],
    noise: &OdometryNoise,
) -> Option<Aside> {
    if prepared.aside.is_empty() {
        return None;
    }
    let there = only(prepared);
    let errors = |terms: &[Term<'_>]| -> Errors {
        let mut terms = terms.to_vec();
        let evidence = Evidence::gather(&there, &mut terms, noise);
        train(&there, (&evidence, &terms), &[], noise)
    };
    let mut kinds: Vec<String> = Vec::new();
    for run in &there.runs {
        let kind = run.kind.to_string();
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    Some(Aside { runs: there.runs.len(), kinds, baseline: errors(before), model: errors(terms) })
}

/// The campaign of the runs kept aside alone, in the light of what is known of the others.
pub(crate) fn only(prepared: &Prepared) -> Prepared {
    let runs: Vec<PreparedRun> = prepared.aside.clone();
    Prepared { robot: prepared.robot, runs, aside: Vec::new(), survey: prepared.survey }
}
