//! The first sentences, for answers of all kinds.

use robot_model::estimation::ErrorPair;

use super::*;
use crate::empty_answer::{nothing_found, step_of};

fn errors(mm: f64, mrad: f64) -> Errors {
    Errors { position_rms_m: mm * 1e-3, heading_rms_rad: mrad * 1e-3, chi: 1.0 }
}

fn answer(class: &[&str], from: Errors, to: Errors) -> Answer {
    let step = StepFound { fitted: to, cross_validated: to, ..step_of(class) };
    Answer {
        baseline: ErrorPair { fitted: from, cross_validated: from },
        steps: vec![step],
        ..nothing_found()
    }
}

fn said(runs: usize, from: Errors, to: Errors) -> String {
    let context = Asked { runs, catalogue: &[], nominal_m: [0.036, 0.372] };
    headline(&answer(&["gyro_bias"], from, to), &context)
}

#[test]
fn what_the_error_does_is_said_as_it_is() {
    for (runs, from, to, expected) in [
        (
            5,
            errors(25.8, 61.2),
            errors(5.0, 9.0),
            "the cross-validated error falls from 25.8 mm, 61.2",
        ),
        (
            5,
            errors(25.8, 61.2),
            errors(25.8, 61.2),
            "cross-validated error stays at 25.8 mm, 61.2 mrad.",
        ),
        (
            5,
            errors(25.81, 61.2),
            errors(25.79, 61.2),
            "cross-validated error stays at 25.8 mm, 61.2 mrad.",
        ),
        (5, errors(5.0, 9.0), errors(5.5, 9.0), "rises from 5.0 mm, 9.0 mrad to 5.5 mm"),
        (5, errors(5.0, 9.0), errors(4.5, 9.1), "changes from 5.0 mm, 9.0 mrad to 4.5 mm"),
        (1, errors(5.0, 9.0), errors(4.5, 8.0), "the error on the fitted run falls from 5.0 mm"),
    ] {
        let headline = said(runs, from, to);
        assert!(headline.contains(expected), "{headline}\n  does not say: {expected}");
    }
}

#[test]
fn what_does_not_matter_is_said_to_be_there_and_how_little_it_moves() {
    let here = errors(1.5, 2.0);
    let found = answer(&["marker_offset"], here, here).with_tolerance(0.02);
    let context = Asked { runs: 5, catalogue: &[], nominal_m: [0.036, 0.372] };
    assert_eq!(
        headline(&found, &context),
        "Nothing that matters is missing: the residuals of these 5 runs are noise. One effect is present, but \
         moves the robot by less than 20 mm: marker_offset."
    );
}

#[test]
fn what_may_be_chance_is_not_said_to_be_small() {
    let mut found = answer(&["marker_offset"], errors(83.2, 2.0), errors(28.8, 2.0));
    found.steps[0].matters = false;
    found.steps[0].nears_runs = false;
    found.steps[0].effect_size_m = 0.0194;
    let context = Asked { runs: 5, catalogue: &[], nominal_m: [0.036, 0.372] };
    assert_eq!(
        headline(&found, &context),
        "Nothing beyond chance is missing: the residuals of these 5 runs are noise. One effect may be present, but the \
         19.4 mm that it explains may be chance: marker_offset."
    );
}

#[test]
fn what_is_beyond_doubt_is_not_said_to_be_chance() {
    let mut found = answer(&["marker_offset"], errors(83.2, 2.0), errors(28.8, 2.0));
    found.steps[0].matters = false;
    found.steps[0].nears_runs = false;
    found.steps[0].effect_size_m = 0.0194;
    found.steps[0].p_value = 7e-22;
    let context = Asked { runs: 5, catalogue: &[], nominal_m: [0.036, 0.372] };
    assert_eq!(
        headline(&found, &context),
        "Nothing that matters is missing: the residuals of these 5 runs are noise. One effect is there, but other errors are \
         so large that whole runs come no nearer by it: marker_offset."
    );
}

#[test]
fn what_explains_less_than_is_left_unexplained_is_not_said_to_be_missing() {
    let mut found = answer(&["backlash"], errors(2.4, 10.5), errors(1.1, 5.0));
    found.steps[0].used_to_predict = false;
    found.unexplained.structure = true;
    let context = Asked { runs: 5, catalogue: &[], nominal_m: [0.036, 0.372] };
    assert_eq!(
        headline(&found, &context),
        "No known effect explains these 5 runs, but the residuals depend on no single variable. One effect explains less than \
         is left unexplained, and may be something else: backlash."
    );
}

#[test]
fn a_number_of_robot_toml_that_is_far_off_is_the_first_thing_said() {
    let mut found = answer(&["wheel_radius_scale"], errors(50.0, 2.0), errors(1.5, 2.0));
    found.steps[0].parameters = vec![robot_model::explain::ParameterFound {
        name: "s".into(),
        unit: "1".into(),
        value: 0.05,
        sigma: 1e-4,
        low95: 0.0498,
        high95: 0.0502,
    }];
    let context =
        Asked { runs: 5, catalogue: &robot_model::effect::CATALOGUE, nominal_m: [0.034, 0.372] };
    let said = headline(&found, &context);
    assert!(said.starts_with("Set wheel_radius_m = 0.0357 (now 0.0340)"), "{said}");
    // As when another effect cancels it: nothing to write down.
    found.steps[0].matters = false;
    let said = headline(&found, &context);
    assert!(said.starts_with("Nothing that matters is missing"), "{said}");
}

#[test]
fn a_radius_and_a_track_width_that_are_off_by_the_same_share_may_be_the_cameras_scale() {
    let of = |ids_and_values: [(&str, f64); 2]| {
        let mut found = answer(&["wheel_radius_scale"], errors(50.0, 2.0), errors(1.5, 2.0));
        found.steps = ids_and_values
            .map(|(id, value)| {
                let parameter = robot_model::explain::ParameterFound {
                    name: "s".into(),
                    unit: "1".into(),
                    value,
                    sigma: 2e-4,
                    low95: value - 4e-4,
                    high95: value + 4e-4,
                };
                StepFound { parameters: vec![parameter], ..step_of(&[id]) }
            })
            .into();
        let catalogue = &robot_model::effect::CATALOGUE;
        headline(&found, &Asked { runs: 5, catalogue, nominal_m: [0.034, 0.372] })
    };
    let said = of([("wheel_radius_scale", 0.0101), ("track_width", 0.0103)]);
    assert!(said.starts_with("Wheel radius and track width are off by the same 1.0 %:"), "{said}");
    // Far off, both numbers are given as well: first of all.
    let said = of([("wheel_radius_scale", 0.0501), ("track_width", 0.0503)]);
    assert!(
        said.starts_with("Set wheel_radius_m = 0.0357 (now 0.0340) and track_width_m ="),
        "{said}"
    );
    assert!(said.contains("off by the same 5.0 %:"), "{said}");
    // Not by the same, and by too little to tell.
    for values in [(0.0101, 0.0113), (0.0008, 0.0009)] {
        let said = of([("wheel_radius_scale", values.0), ("track_width", values.1)]);
        assert!(said.starts_with("Two effects are missing:"), "{said}");
    }
}

#[test]
fn outliers_of_the_poses_alone_are_not_the_robots() {
    use robot_model::residuals::Regressor;
    let mut found = nothing_found();
    found.unexplained.structure = true;
    found.unexplained.outliers = true;
    found.unexplained.depends_on = vec![Regressor::TimeInRun];
    let context = Asked { runs: 5, catalogue: &[], nominal_m: [0.036, 0.372] };
    let said = headline(&found, &context);
    assert!(said.starts_with("Nothing is missing from the robot's model, but"), "{said}");
    // Nor is what happened once.
    found.unexplained.sudden = vec![robot_model::residuals::SuddenMotion {
        run: "04_free".into(),
        from_s: 10.0,
        to_s: 10.3,
        turn_rad: 0.17,
        turn_sigma_rad: 1e-3,
        wheels_m: [-0.027, 0.0],
    }];
    assert_eq!(
        headline(&found, &context),
        "In 04_free the robot moved for a moment as its wheels did not, which may hide other effects: drive it again, or \
         remove it. No effect that matters stands out beside that."
    );
    // Beside anything else outliers explain nothing away.
    found.unexplained.sudden.clear();
    found.unexplained.depends_on.push(Regressor::Speed);
    let said = headline(&found, &context);
    assert!(said.starts_with("No known effect explains these 5 runs"), "{said}");
}
