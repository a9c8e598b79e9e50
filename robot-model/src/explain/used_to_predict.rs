//! Which of the effects found predict other runs?
//!
//! What an effect does in these runs it does in others only if it is what it seems to be. Where a model leaves more unexplained
//! than the effect removes, the effect may be an imitation of a part of that, and other motions call for another one. So effects
//! predict that certainly remove more than is left over the error floor:
//!
//! ```text
//! c^2 (D(without it) - D(with it)) > D(with it) - D(floor)              (1)
//! ```
//!
//! with D the mean squared displacement of the wheels in tracks of runs that nothing was fitted to, and c the share of its value
//! that is certain ([`crate::estimation::tolerance`]). What does not matter goes first, then the weakest of the others; what is left
//! of them is then judged anew, so of two that can stand in for each other one stays.
//!
//! Radii and track width predict always: every robot has them. So do the effects of the user's own model, and those of a
//! sensor, which move no track.

use crate::effect::definition::ActsOn;
use crate::estimation::errors::{Errors, displacement_m};
use crate::explain::answer::StepFound;
use crate::explain::model_choice::Choice;
use crate::selection::candidates::is_geometry;

/// The effects of the choice that do not predict, by their place in it; `steps` are told.
///
/// `missing` are those that the user's model lacks, `floor` is the error that is reachable, if something is left over it beyond
/// chance.
pub(super) fn left_out(
    choice: &Choice<'_>,
    (missing, steps): (&[usize], &mut [StepFound]),
    (floor, tolerance_m): (Option<&Errors>, f64),
) -> Vec<usize> {
    let Choice { prepared, selection, .. } = choice;
    let may_go = |index: usize| {
        let effect = selection.fitted.terms[index].effect;
        !is_geometry(effect) && effect.facts().acts_on != ActsOn::Gyro
    };
    let found = missing.iter().zip(steps.iter()).filter(|(index, _)| may_go(**index));
    let (mut matter, rest): (Vec<_>, Vec<_>) =
        found.partition(|(_, step)| step.matters_at(tolerance_m));
    let mut left_out: Vec<usize> = rest.into_iter().map(|(index, _)| *index).collect();
    let square_m2 = |without: &[usize]| selection.screening.displacement_m2(prepared, without);
    let mut with_m2 = square_m2(&left_out);
    while let Some(floor) = floor {
        let without = |(place, (index, step)): (usize, &(&usize, &StepFound))| {
            let without_m2 = square_m2(&[&left_out[..], &[**index]].concat());
            let certain = (step.least_size_m / step.effect_size_m).powi(2);
            (place, without_m2, certain * (without_m2 - with_m2))
        };
        let weakest = matter.iter().enumerate().map(without).min_by(|a, b| a.2.total_cmp(&b.2));
        let over_m2 = with_m2 - displacement_m(floor, prepared.robot.track_width_m).powi(2);
        let Some((place, without_m2, _)) = weakest.filter(|of| of.2 < over_m2) else { break };
        left_out.push(*matter.remove(place).0);
        with_m2 = without_m2;
    }
    for (index, step) in missing.iter().zip(steps) {
        step.used_to_predict = !left_out.contains(index);
    }
    left_out
}
