//! What could any model reach? How far above it is the error of the chosen effects, on what does that depend, and which
//! equation says it?

use crate::effect::definition::Effect;
use crate::estimation::errors::{Errors, displacement_m, lower};
use crate::estimation::tolerance::resolved_m;
use crate::explain::model_choice::{Choice, EXCESS_MAX};
use crate::explain::quiet_runs::reachable_on_quiet_runs;
use crate::residuals::expression::expression;
use crate::residuals::lack_of_fit::{DrivenAgain, LackOfFit, lack_of_fit};
use crate::residuals::regressor::Regressor;
use crate::residuals::sudden_motion::sudden_motions;
use crate::residuals::unexplained::{Unexplained, unexplained};

/// What comes back when runs are driven again is worth a word if the error exceeds the rest by this factor.
const COMES_BACK_MIN: f64 = 1.1;

/// Random walk of the heading \[rad/sqrt(m)\] that is more than wheels on a floor have: twice that of the robot of
/// docs/real-data.md.
const WALK_OF_WHEELS: f64 = 0.01;

/// The reachable error, and what is left above it by the last of the models that have these cross-validated errors.
///
/// What one of them reaches, any model at all can reach; see [`lowest`].
pub(super) fn reachable_and_unexplained<'a>(
    choice: &Choice<'a>,
    reached: &[Errors],
    catalogue: &[&'a dyn Effect],
) -> (Errors, Unexplained) {
    let Choice { prepared, flexible, alternative, .. } = choice;
    let track_width_m = prepared.robot.track_width_m;
    let mut found = unexplained(prepared, &choice.selected);
    if flexible.excess(track_width_m) > EXCESS_MAX {
        // Beside other weights of the same effects, an equation would be judged by the wrong ones.
        if alternative.as_ref().is_none_or(|alternative| alternative.geometry_only) {
            found.expression = expression(prepared, &choice.selection.fitted, flexible);
        }
        found.structure = true;
        add(&mut found.depends_on, flexible.depends_on.iter().flatten().copied());
    }
    let begun = match alternative {
        Some(alternative) => lower(&flexible.reachable, &alternative.errors, track_width_m),
        None => flexible.reachable,
    };
    let on_all = lowest(begun, reached, track_width_m);
    let on_quiet = reachable_on_quiet_runs(prepared, &choice.selected, catalogue, &on_all);
    let mut reachable = on_all;
    if let Some(quiet) = on_quiet {
        reachable = lower(&on_all, &quiet.reachable, track_width_m);
        found.structure = true;
        found.runs_off = quiet.off;
        add(&mut found.depends_on, [quiet.differ_by].into_iter());
    }
    let after = *reached.last().unwrap_or(&reachable);
    let lack = lack_of_fit(prepared, &choice.selected);
    if let Some(lack) = lack.filter(LackOfFit::comes_back) {
        let pure = lack.pure(&after);
        let [all_m, pure_m] = [&after, &pure].map(|errors| displacement_m(errors, track_width_m));
        if all_m > COMES_BACK_MIN * pure_m {
            let back_m2 = after.position_rms_m.powi(2) - pure.position_rms_m.powi(2);
            found.driven_again = DrivenAgain::ComesBack(back_m2.max(0.0).sqrt());
            found.structure = true;
            found.p_value = found.p_value.min(lack.p_value);
            reachable = lower(&reachable, &pure, track_width_m);
        }
    } else if lack.is_some_and(|lack| lack.is_noise()) {
        found.driven_again = DrivenAgain::Differ;
    } else if choice.selected.noise.heading_walk > WALK_OF_WHEELS {
        found.random_turn_rad = Some(choice.selected.noise.heading_walk);
    }
    let square = |errors: &Errors| errors.position_rms_m.powi(2);
    found.size_m = (square(&after) - square(&reachable)).max(0.0).sqrt();
    if displacement_m(&after, track_width_m) < resolved_m(prepared, &choice.selected.noise) {
        // A simulator without noise leaves errors of arithmetic, and these depend on something always.
        found = Unexplained { p_value: 1.0, places: found.places, ..Unexplained::default() };
    }
    if found.outliers || !found.runs_off.is_empty() {
        found.sudden = sudden_motions(prepared, &choice.selected);
    }
    // What matters by one test may be little by another.
    found.slight.retain(|regressor| !found.depends_on.contains(regressor));
    (least_of_each(reachable, reached), found)
}

/// The least error of position and the least of heading that any of these models reaches: one may have the one and another the
/// other, and no model can be said to reach less than any can.
fn least_of_each(reachable: Errors, reached: &[Errors]) -> Errors {
    reached.iter().fold(reachable, |least, other| Errors {
        position_rms_m: least.position_rms_m.min(other.position_rms_m),
        heading_rms_rad: least.heading_rms_rad.min(other.heading_rms_rad),
        chi: least.chi.min(other.chi),
    })
}

/// Adds what a flexible model depends on. That runs differ is not what makes them differ: where anything else is found, it
/// comes last.
fn add(depends_on: &mut Vec<Regressor>, more: impl Iterator<Item = Regressor>) {
    for regressor in more {
        if !depends_on.contains(&regressor) {
            depends_on.push(regressor);
        }
        depends_on.sort_by_key(|regressor| *regressor == Regressor::Run);
    }
}

/// The lowest of these errors and those that models reach, the last of which is the one chosen.
///
/// The choice goes by residuals over their noise (`chi`). A model that leaves more of that may have less displacement by
/// chance, where few poses tell it: heading for position. It reaches nothing.
fn lowest(begun: Errors, reached: &[Errors], track_width_m: f64) -> Errors {
    let chosen = reached.last().map_or(f64::INFINITY, |last| last.chi);
    let counts = reached.iter().filter(|errors| errors.chi <= chosen);
    counts.fold(begun, |least, other| lower(&least, other, track_width_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_runs_differ_by_comes_before_that_they_differ() {
        use Regressor::{Heading, Run, Speed};
        let with = |more: &[Regressor]| {
            let mut depends_on = vec![Run, Speed];
            add(&mut depends_on, more.iter().copied());
            depends_on
        };
        assert_eq!(with(&[Heading]), [Speed, Heading, Run]);
        assert_eq!(with(&[Speed]), [Speed, Run]);
        assert_eq!(with(&[]), [Run, Speed], "the flexible model found nothing");
    }

    #[test]
    fn an_error_of_heading_for_one_of_position_is_no_lower_floor() {
        // Ends of twenty runs: 1.3 mm and 2.4 mrad without the effect, 1.6 mm and 1.6 mrad with it.
        let of = |mm: f64, mrad: f64, chi: f64| Errors {
            position_rms_m: 1e-3 * mm,
            heading_rms_rad: 1e-3 * mrad,
            chi,
        };
        let (nominal, chosen) = (of(1.3, 2.4, 1.17), of(1.6, 1.6, 0.94));
        assert!(displacement_m(&nominal, 0.37) < displacement_m(&chosen, 0.37));
        assert_eq!(lowest(chosen, &[nominal, chosen], 0.37), chosen);
        // A model that is better by both reaches less than the flexible one.
        assert_eq!(lowest(of(1.7, 1.7, 1.0), &[nominal, chosen], 0.37), chosen);
        assert_eq!(lowest(of(1.0, 1.0, 1.0), &[nominal, chosen], 0.37), of(1.0, 1.0, 1.0));
    }

    #[test]
    fn no_model_reaches_less_than_any_can() {
        // A flexible model with less error of position than that of the effects, and more of heading.
        let of = |mm: f64, mrad: f64, chi: f64| Errors {
            position_rms_m: 1e-3 * mm,
            heading_rms_rad: 1e-3 * mrad,
            chi,
        };
        let (nominal, chosen) = (of(29.2, 39.0, 4.0), of(4.7, 9.3, 1.2));
        let reachable = lowest(of(2.1, 12.7, 1.0), &[nominal, chosen], 0.287);
        assert_eq!(reachable, of(2.1, 12.7, 1.0));
        assert_eq!(least_of_each(reachable, &[nominal, chosen]), of(2.1, 9.3, 1.0));
        // A model that was not chosen may have less of one as well.
        let (nominal, chosen) = (of(13.7, 48.9, 1.3), of(14.2, 48.6, 1.1));
        let reachable = least_of_each(of(14.0, 48.6, 1.05), &[nominal, chosen]);
        assert_eq!(reachable, of(13.7, 48.6, 1.05));
    }
}
