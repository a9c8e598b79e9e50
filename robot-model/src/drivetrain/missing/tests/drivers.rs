//! Motor drivers that do not give the voltage of their duty, or not at once.

use super::*;

/// Bent by a power of the voltage, where the effect has a fraction: what is left is little.
#[test]
fn a_bent_duty_is_named_and_hardly_anything_is_left() {
    let (named, b, answer) = only(Motors { bend: 0.1, ..SOUND });
    assert_eq!(named, ["bridge_curve"]);
    assert!(b.value > 0.0 && b.value > 5.0 * b.half_width_95, "{b:?}");
    let left = answer.steps[0].errors.cross_validated_m / answer.resolution_m;
    assert!(left < 1.2 && !answer.unexplained.structure, "{left}");
    // Bent the other way, by less.
    let answer = Motors { bend: -0.06, ..SOUND }.answer();
    let first = &answer.steps[0];
    assert_eq!(first.effect.facts().id, "bridge_curve");
    assert!(first.parameters[0].value < -2.0 * first.parameters[0].half_width_95, "{answer:#?}");
    assert!(first.errors.cross_validated_m < 0.3 * answer.baseline.cross_validated_m);
}

/// A soft start is no delay: small steps lag less than large ones. Nothing in the catalogue does that.
#[test]
fn a_driver_that_changes_its_voltage_only_so_fast_is_flagged() {
    let answer = Motors { slew_v_per_s: 100.0, ..SOUND }.answer();
    assert!(answer.unexplained.depends_on.contains(&MotorRegressor::VoltageChange), "{answer:#?}");
    // A plain delay is named, and then nothing lags.
    let answer = Motors { late_s: 0.004, ..SOUND }.answer();
    assert!(!answer.unexplained.structure, "{answer:#?}");
}
