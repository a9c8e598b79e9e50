//! What holds of every effect: the identity at zero, facts that are complete, and no confusion that is not mutual.

use super::*;
use crate::drivetrain::model::WheelMotor;
use crate::kinematics::WheelPair;

const EXCITATION: Excitation =
    Excitation { speed_mps_max: 0.4, gear_reduction: 1.0, counts_per_wheel_turn: 900.0 };

fn acting() -> Acting {
    let motor = WheelMotor {
        ks_forward_v: 0.5,
        ks_backward_v: 0.5,
        kv_v_s_per_m: 24.0,
        ka_v_s2_per_m: 0.7,
    };
    Acting { volts: 3.0, motor }
}

#[test]
fn every_effect_is_the_identity_at_zero() {
    for effect in MOTOR_CATALOGUE {
        let id = effect.facts().id;
        for p in effect.starts(&EXCITATION) {
            assert_eq!(p.len(), effect.facts().parameters.len(), "{id}");
            for (speed, volts) in [(0.0, 0.2), (0.3, 3.0), (-0.2, -4.0), (0.1, -2.0)] {
                let turns = WheelPair::new(0.3, 7.7);
                let moments = moments(
                    WheelPair::both(speed),
                    (WheelPair::both(volts), 12.0),
                    turns,
                    (77.0, 8.0, 0.4),
                );
                for moment in [moments.left, moments.right] {
                    let mut changed = acting();
                    effect.act(&p, &moment, &mut changed);
                    assert_eq!(changed, acting(), "{id}");
                }
            }
            assert_eq!(effect.delay_s(&p), 0.0, "{id}");
            assert_eq!(effect.play(&p), None, "{id}");
        }
    }
}

#[test]
fn facts_are_complete() {
    for effect in MOTOR_CATALOGUE {
        let facts = effect.facts();
        for text in [facts.name, facts.equation, facts.sign, facts.shown_by, facts.remedy] {
            assert!(!text.is_empty(), "{}", facts.id);
        }
        assert!(facts.parameters.iter().any(|p| p.role == MotorRole::Amplitude), "{}", facts.id);
        for parameter in facts.parameters {
            assert!(parameter.low < parameter.high && parameter.usual > 0.0, "{}", facts.id);
        }
    }
}

#[test]
fn the_signs_are_those_of_the_facts() {
    let act = |id: &str, p: &[f64], speed: f64, volts: f64| {
        let pair = WheelPair::both(speed);
        let moments =
            moments(pair, (WheelPair::both(volts), 12.0), WheelPair::both(0.0), (100.0, 10.0, 0.0));
        [moments.left, moments.right].map(|moment| {
            let mut changed = Acting { volts, ..acting() };
            find(id).unwrap().act(p, &moment, &mut changed);
            changed
        })
    };
    let [left, right] = act("side_asymmetry", &[0.1, 0.02], 0.2, 3.0);
    assert!(left.motor.ks_forward_v > 0.5 && right.motor.ks_forward_v < 0.5);
    assert!(left.motor.kv_v_s_per_m > 24.0 && right.motor.kv_v_s_per_m < 24.0);
    let [left, right] = act("direction_asymmetry", &[0.1, 0.02], 0.2, 3.0);
    assert!(left.volts < 3.0 && right.volts > 3.0);
    assert!(left.motor.kv_v_s_per_m > 24.0 && right.motor.kv_v_s_per_m < 24.0);
    assert!(act("load_torque", &[0.1, 0.0], 0.2, 3.0)[0].volts > 3.0);
    let slow = act("stribeck", &[0.2, 0.05, 2.0], 0.01, 3.0)[0].motor.ks_backward_v;
    let fast = act("stribeck", &[0.2, 0.05, 2.0], 0.3, 3.0)[0].motor.ks_backward_v;
    assert!(slow > 0.65 && fast < 0.51, "{slow} {fast}");
    assert_eq!(act("static_friction", &[0.2], 0.0, 3.0)[1].motor.ks_forward_v, 0.7);
    assert!((act("static_friction", &[0.2], 0.1, 3.0)[1].motor.ks_forward_v - 0.5).abs() < 1e-9);
    // What is swallowed never turns a voltage round.
    assert_eq!(act("dead_band", &[0.2], 0.1, 3.0)[0].volts, 2.8);
    assert_eq!(act("dead_band", &[0.2], 0.1, -0.1)[0].volts, 0.0);
    // Of small voltages a larger share is missing.
    let missing = |volts: f64| volts - act("bridge_curve", &[0.2, 3.0], 0.1, volts)[0].volts;
    assert!(missing(3.0) > 0.2 && missing(0.3) / 0.3 > 1.5 * missing(3.0) / 3.0);
    assert!((missing(1e-3) / 1e-3 - 0.2).abs() < 1e-3 && missing(12.0) == 0.0);
    assert_eq!(missing(-3.0), -missing(3.0));
    assert!(act("quadratic_drag", &[1.0], -0.5, -3.0)[0].volts > -3.0);
    assert!(act("supply_sag", &[1e-3], 0.01, 3.0)[0].volts < 3.0);
    for warm in [[1e-3, 0.0, 30.0], [0.0, 0.1, 30.0]] {
        let hot = act("heating", &warm, 0.2, 3.0)[0].motor;
        assert!(hot.ka_v_s2_per_m > 0.7 && hot.ks_forward_v > 0.5 && hot.kv_v_s_per_m == 24.0);
    }
    assert!((act("cogging", &[0.1, 0.0, 0.0, 0.0, 12.0], 0.2, 3.0)[0].volts - 2.9).abs() < 1e-12);
}
