//! Effects of a user's own, beside those of the catalogue.

use std::sync::Arc;

use super::*;
use crate::drivetrain::effect::MotorCustom;

fn own(equation: &str) -> KnownMotorEffect {
    let built = MotorCustom::from_equation(equation).unwrap().build().unwrap();
    KnownMotorEffect::Own(Arc::new(built))
}

#[test]
fn an_expression_gives_the_same_fit_as_the_built_in_effect() {
    let experiments = Motors { drag: 4.0, ..SOUND }.campaign(7);
    let fitted = |effect: KnownMotorEffect| fit_chosen(&ROBOT, &experiments, &[effect]).unwrap();
    let built_in = fitted(KnownMotorEffect::find("quadratic_drag", &[]).unwrap());
    let expression = fitted(own("dV = q * v * abs(v)"));
    let (a, b) = (&expression.effects[0], &built_in.effects[0]);
    let off = a.parameters[0].value / b.parameters[0].value - 1.0;
    assert!(off.abs() < 1e-3, "{a:?} {b:?}");
    let off = a.parameters[0].half_width_95 / b.parameters[0].half_width_95 - 1.0;
    assert!(off.abs() < 0.02, "{a:?} {b:?}");
    let off = expression.errors.cross_validated_m / built_in.errors.cross_validated_m - 1.0;
    assert!(off.abs() < 1e-3 && a.matters, "{off} {a:?}");
    assert_eq!(a.parameters[0].unit, "V s^2/m^2");
}

#[test]
fn explain_names_an_effect_of_the_users_own_that_the_catalogue_lacks() {
    let experiments = Motors { drag: 4.0, ..SOUND }.campaign(7);
    let mut catalogue = KnownMotorEffect::all(&[]);
    catalogue.retain(|effect| effect.facts().id != "quadratic_drag");
    catalogue.push(own("dV = q * v * abs(v)"));
    // Nothing that these motors have.
    catalogue.push(own("dkS = k * max(0, cos(phi))"));
    let catalogue = catalogue;
    let answer = missing_with(&ROBOT, &experiments, &catalogue).unwrap();
    let found: Vec<&str> = answer.steps.iter().map(|step| step.effect.facts().id).collect();
    assert_eq!(found, ["custom_dv"], "{answer:#?}");
    assert!(holds(&answer.steps[0].parameters[0], 4.0), "{answer:#?}");
    assert!(answer.tried.iter().any(|tried| tried.effect.facts().id == "custom_dks"));
}

/// What no effect of the catalogue does: the right wheel rubs once a turn.
#[test]
fn an_effect_of_one_motor_that_the_catalogue_does_not_have_is_needed_and_its_size_is_right() {
    let experiments = Motors { rubs: 0.2, ..SOUND }.campaign(7);
    let fitted = |effects: &[KnownMotorEffect]| fit_chosen(&ROBOT, &experiments, effects).unwrap();
    let before = fitted(&[]);
    let after = fitted(&[own("dkS_right = k * max(0, cos(phi))")]);
    assert!(after.errors.cross_validated_m < 0.2 * before.errors.cross_validated_m, "{after:#?}");
    assert!(after.effects[0].matters && holds(&after.effects[0].parameters[0], 0.2), "{after:#?}");
    // The other wheel does not.
    let other = fitted(&[own("dkS_left = k * max(0, cos(phi))")]);
    assert!(other.errors.cross_validated_m > 0.9 * before.errors.cross_validated_m, "{other:#?}");
}

/// A driver whose mean voltage is no straight line of the duty, by a catalogue without such a driver: `explain` says that
/// something depends on the voltage, and an equation of the voltage takes it away.
#[test]
fn what_explain_flags_an_equation_takes_away() {
    let experiments = Motors { bend: 0.1, ..SOUND }.campaign(7);
    let mut catalogue = KnownMotorEffect::all(&[]);
    catalogue.retain(|effect| effect.facts().id != "bridge_curve");
    let flagged = missing_with(&ROBOT, &experiments, &catalogue).unwrap().unexplained;
    assert!(flagged.depends_on.contains(&MotorRegressor::Voltage), "{flagged:?}");
    let equation = own("dV = -b * volts * ln(max(abs(volts), 0.1[V]) / 6[V])");
    let answer = missing_with(&ROBOT, &experiments, &[equation]).unwrap();
    assert!(answer.steps.len() == 1 && !answer.unexplained.structure, "{answer:#?}");
    let (before, after) = (answer.baseline, answer.steps[0].errors);
    assert!(after.cross_validated_m < 0.3 * before.cross_validated_m, "{before:?} {after:?}");
    assert!(holds(&answer.steps[0].parameters[0], 0.1), "{answer:#?}");
}

/// A shape is fitted with its amplitude.
#[test]
fn the_shape_of_an_expression_is_fitted() {
    let experiments = Motors { slow: (0.2, 0.06), ..SOUND }.campaign(7);
    let effects = [own("dkS = k * exp(-(v / w)^2)")];
    let fitted = fit_chosen(&ROBOT, &experiments, &effects).unwrap();
    let [k, w] = fitted.effects[0].parameters.as_slice() else { panic!() };
    assert!(fitted.effects[0].matters && holds(k, 0.2) && holds(w, 0.06), "{fitted:#?}");
}

/// Friction that acts only near rest, where most experiments are not: however an amplitude is scaled, its fit is the same, and it
/// never ends worse than without it.
#[test]
fn an_effect_near_rest_is_fitted_however_it_is_scaled() {
    let experiments = Motors { slow: (0.2, 0.05), ..SOUND }.campaign(7);
    let fitted = |equation: &str| fit_chosen(&ROBOT, &experiments, &[own(equation)]).unwrap();
    let before = fit_chosen(&ROBOT, &experiments, &[]).unwrap();
    for (scale, times) in [("", 1.0), ("1000 * ", 1000.0), ("0.001 * ", 0.001)] {
        let after = fitted(&format!("dkS = {scale}k * exp(-(v / 0.05[m/s])^2)"));
        let k = &after.effects[0].parameters[0];
        assert!((k.value * times - 0.2).abs() < 0.02, "{scale}: {k:?}");
        assert!(after.errors.fitted_m < 0.3 * before.errors.fitted_m, "{scale}: {after:#?}");
    }
    for equation in ["dkS = k * exp(-(v / 0.01[m/s])^2)", "dkS = k * exp(-abs(v) / 0.02[m/s])"] {
        let after = fitted(equation);
        assert!(after.errors.fitted_m <= before.errors.fitted_m, "{equation}: {after:#?}");
    }
}

#[test]
fn what_the_rest_of_the_model_can_do_already_is_refused() {
    let experiments = Motors { drag: 4.0, ..SOUND }.campaign(7);
    let drag = || own("dV = q * v * abs(v)");
    let scaled = own("dV_left = 3 * q * v * abs(v)");
    let other = own("dV_right = q * v * abs(v)");
    for (effects, refused) in [
        (vec![drag(), drag()], "custom_dv"),
        (vec![KnownMotorEffect::find("quadratic_drag", &[]).unwrap(), drag()], "custom_dv"),
        (vec![drag(), scaled.clone(), other.clone()], "custom_dv_right"),
        (vec![own("dkV = k")], "custom_dkv"),
        (vec![own("dkA = k")], "custom_dka"),
        (vec![own("dV = k * v")], "custom_dv"),
    ] {
        let found = fit_chosen(&ROBOT, &experiments, &effects);
        let expected = MissingError::Inseparable { effect: refused.to_owned() };
        assert_eq!(found.map(|model| model.effects.len()), Err(expected), "{effects:#?}");
    }
    // One wheel's is an effect of its own.
    fit_chosen(&ROBOT, &experiments, &[drag(), scaled]).unwrap();
}

/// As the back-EMF and the friction of a motor together: what each would be, these experiments hardly tell.
#[test]
fn what_the_experiments_do_not_determine_is_refused_or_no_worse() {
    let experiments = Motors { drag: 1.0, ..SOUND }.campaign(7);
    let before = fit_chosen(&ROBOT, &experiments, &[]).unwrap().errors.cross_validated_m;
    for equation in ["dkS = k * abs(volts)", "dkS = k * exp(-abs(v)/w)", "dV = a*sin(n*phi + p)"] {
        match fit_chosen(&ROBOT, &experiments, &[own(equation)]) {
            Ok(model) => {
                let after = model.errors.cross_validated_m;
                assert!(after < 2.5 * before, "{equation}: {before} {after}");
            }
            Err(error) => assert!(
                matches!(error, MissingError::Unstable { .. } | MissingError::Inseparable { .. }),
                "{equation}: {error:?}"
            ),
        }
    }
}
