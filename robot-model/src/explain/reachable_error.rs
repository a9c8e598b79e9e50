//! What could any model reach? How far above it is the error of the chosen effects, on what does that depend, and which
//! equation says it?

use crate::estimation::errors::Errors;
use crate::explain::model_choice::{Choice, EXCESS_MAX};
use crate::explain::tolerance::resolved_m;
use crate::recording::campaign::Prepared;
use crate::residuals::expression::expression;
use crate::residuals::flexible_model::displacement_m;
use crate::residuals::unexplained::{Unexplained, unexplained};

/// The reachable error, and what is left above it by the last of the models that have these cross-validated errors.
///
/// What one of them reaches, any model at all can reach.
pub(super) fn reachable_and_unexplained(
    choice: &Choice<'_>,
    reached: &[Errors],
) -> (Errors, Unexplained) {
    let Choice { prepared, flexible, alternative, .. } = choice;
    let mut found = unexplained(prepared, &choice.selected);
    if flexible.excess(prepared.robot.track_width_m) > EXCESS_MAX {
        // Beside other weights of the same effects, an equation would be judged by the wrong ones.
        if alternative.as_ref().is_none_or(|alternative| alternative.geometry_only) {
            found.expression = expression(prepared, &choice.selection.fitted, flexible);
        }
        found.structure = true;
        for regressor in flexible.depends_on.iter().flatten() {
            if !found.depends_on.contains(regressor) {
                found.depends_on.push(*regressor);
            }
        }
    }
    let alternative = alternative.as_ref().map(|alternative| &alternative.errors);
    let reachable = alternative
        .into_iter()
        .chain(reached)
        .fold(flexible.reachable, |reachable, other| lower(&reachable, other, prepared));
    let after = reached.last().unwrap_or(&reachable);
    let square = |errors: &Errors| errors.position_rms_m.powi(2);
    found.size_m = (square(after) - square(&reachable)).max(0.0).sqrt();
    if displacement_m(after, prepared.robot.track_width_m)
        < resolved_m(prepared, &choice.selected.noise)
    {
        // A simulator without noise leaves errors of arithmetic, and these depend on something always.
        found = Unexplained { p_value: 1.0, places: found.places, ..Unexplained::default() };
    }
    (reachable, found)
}

/// The lower of two reachable errors.
fn lower(one: &Errors, other: &Errors, prepared: &Prepared) -> Errors {
    let track_width_m = prepared.robot.track_width_m;
    let lower = displacement_m(other, track_width_m) < displacement_m(one, track_width_m);
    if lower { *other } else { *one }
}
