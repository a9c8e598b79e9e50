//! What of the effects found predicts other runs?

use core::f64::consts::TAU;

use crate::effect::composition::Term;
use crate::explain::{Answer, explain};
use crate::recording::motion::Step;
use crate::tests::synthetic::{TurnsPerMetre, campaign, full_plan, term};

/// A floor in waves, as no effect of the catalogue is.
const WAVES: TurnsPerMetre =
    TurnsPerMetre(|step: &Step| 0.08 * (2.0 * TAU * step.place_m[0]).sin());

/// The answer about a robot with a wrong track width and a marker offset, over a flat floor or one in waves.
fn answer(in_waves: bool, seed: u64) -> Answer {
    let mut truth = vec![term("track_width", &[0.006]), term("marker_offset", &[0.0015, 0.0])];
    if in_waves {
        truth.push(Term::new(&WAVES, vec![]));
    }
    explain(&campaign(&full_plan(), &truth, seed)).unwrap()
}

fn predicts(answer: &Answer, id: &str) -> bool {
    answer.predicts_with.iter().any(|one| one.effect == id)
}

#[test]
fn an_effect_smaller_than_what_is_left_unexplained_is_named_and_predicts_nothing() {
    for seed in 0..2 {
        let flat = answer(false, seed);
        assert!(!flat.unexplained.structure);
        assert!(flat.steps.iter().all(|step| step.used_to_predict), "{:?}", flat.steps);
        assert!(predicts(&flat, "track_width") && predicts(&flat, "marker_offset"));
        // A millimetre of marker offset, beside ten that nothing explains.
        let waves = answer(true, seed + 2);
        assert!(waves.unexplained.structure);
        let step = waves.steps.iter().find(|step| step.effect == "marker_offset").unwrap();
        assert!(!step.used_to_predict, "{step:?}");
        assert!(!predicts(&waves, "marker_offset"), "{:?}", waves.predicts_with);
    }
}

#[test]
fn what_is_told_of_radii_and_track_width_is_what_predicts() {
    let waves = answer(true, 2);
    assert!(waves.steps.iter().any(|step| !step.used_to_predict));
    let told = waves.steps.iter().find(|step| step.effect == "track_width").unwrap();
    let predicts = waves.predicts_with.iter().find(|one| one.effect == "track_width").unwrap();
    assert_eq!(told.parameters, predicts.parameters);
    // The errors are those of that model, not of the one with a marker offset.
    let own_m = waves.predicts_by.cross_validated.position_rms_m;
    let all_m = waves.steps.last().unwrap().cross_validated.position_rms_m;
    assert!((own_m - all_m).abs() > 1e-6 && own_m < 1.1 * all_m, "{own_m} {all_m}");
}

#[test]
fn radii_and_track_width_predict_whatever_is_left_unexplained() {
    let waves = answer(true, 2);
    let of_geometry = ["wheel_radius_scale", "wheel_radius_ratio", "track_width"];
    assert!(of_geometry.iter().all(|id| predicts(&waves, id)), "{:?}", waves.predicts_with);
}
