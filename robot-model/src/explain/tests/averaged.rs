//! What predicts other runs.

use crate::explain::{Answer, Averaged, explain};
use crate::recording::nominal_run::Piece;
use crate::tests::synthetic::{campaign, full_plan, part_of_plan, term};

fn found(answer: &Answer) -> Vec<&str> {
    answer.steps.iter().map(|step| step.effect.as_str()).collect()
}

#[test]
fn radii_and_track_width_are_fitted_together_and_only_what_is_found_is_named() {
    let answer =
        explain(&campaign(&full_plan(), &[term("wheel_radius_ratio", &[0.008])], 5)).unwrap();
    assert_eq!(found(&answer), ["wheel_radius_ratio"]);
    let along: Vec<&str> = answer.fitted_along.iter().map(|one| one.effect.as_str()).collect();
    assert_eq!(along, ["wheel_radius_scale", "track_width"]);
    for parameter in answer.fitted_along.iter().flat_map(|one| &one.parameters) {
        assert!(parameter.low95 < 0.0 && 0.0 < parameter.high95, "{parameter:?}");
    }
    assert_eq!(answer.predicts_with.len(), 3);
}

#[test]
fn a_sound_robot_has_nothing_fitted_along() {
    let answer = explain(&campaign(&full_plan(), &[], 203)).unwrap();
    assert!(answer.fitted_along.is_empty() && answer.predicts_with.is_empty());
}

#[test]
fn faster_than_its_runs_a_class_predicts_what_it_did_at_their_speed() {
    // At one speed a radius that grows with the speed looks like a wrong radius.
    let plan = part_of_plan(&["out_and_back_1"]);
    let answer = explain(&campaign(&plan, &[term("wheel_radius_scale", &[0.01])], 0)).unwrap();
    let limited: Vec<&Averaged> =
        answer.predicts_with.iter().filter(|one| one.up_to_mps.is_some()).collect();
    assert!(limited.iter().any(|one| one.effect == "speed_growth"), "{:?}", answer.predicts_with);
    let geometry = ["wheel_radius_scale", "wheel_radius_ratio", "track_width"];
    assert!(!limited.iter().any(|one| geometry.contains(&one.effect.as_str())));
    // From 0.3 to 0.6 m/s, four times the growth would be carried over.
    let mut faster = plan.clone();
    faster[0].2 = vec![Piece::Straight { travel_m: 3.0, speed_mps: 0.6 }];
    let faster = campaign(&faster, &[term("wheel_radius_scale", &[0.01])], 1);
    let mut unlimited = answer.clone();
    unlimited.predicts_with.iter_mut().for_each(|one| one.up_to_mps = None);
    let off = |answer: &Answer| answer.errors_on(&faster).unwrap().position_rms_m;
    let (limited_m, unlimited_m) = (off(&answer), off(&unlimited));
    assert!(limited_m < 0.5 * unlimited_m, "{limited_m} against {unlimited_m}");
}

#[test]
fn what_runs_cannot_tell_apart_predicts_other_runs_by_shares_that_make_one() {
    // At one speed and without turns, counts that are lost at speed look like a radius.
    let plan: Vec<(String, f64, Vec<Piece>)> = part_of_plan(&["out_and_back_0"]);
    let answer = explain(&campaign(&plan, &[term("wheel_radius_scale", &[0.02])], 0)).unwrap();
    let step = &answer.steps[0];
    assert!(step.class.len() > 1, "{:?}", step.class);
    let share = |one: &Averaged| {
        let parameter = &one.parameters[0];
        assert!(parameter.low95 <= 0.0 && 0.0 <= parameter.high95, "{parameter:?}");
        let alone = match one.effect == step.effect {
            true => step.parameters[0].value,
            false if parameter.value > 0.0 => parameter.high95,
            false => parameter.low95,
        };
        parameter.value / alone
    };
    let in_class = |one: &&Averaged| step.class.contains(&one.effect);
    let shares: Vec<f64> = answer.predicts_with.iter().filter(in_class).map(share).collect();
    assert!(shares.len() > 1, "{:?}", answer.predicts_with);
    assert!(shares.iter().all(|share| (0.0..1.0).contains(share)), "{shares:?}");
    assert!((shares.iter().sum::<f64>() - 1.0).abs() < 0.02, "{shares:?}");
}
