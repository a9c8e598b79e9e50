use super::plausible::sample_moments;
use super::*;
use crate::drivetrain::effect::{
    Acting, Excitation, MOTOR_CATALOGUE, Moment, MotorEffect, MotorRole, find,
};
use crate::drivetrain::model::WheelMotor;
use crate::expression::{ExpressionError, ExpressionProblem};

fn built(equation: &str) -> CustomMotorEffect {
    MotorCustom::from_equation(equation).unwrap().build().unwrap()
}

fn acting() -> Acting {
    let motor = WheelMotor {
        ks_forward_v: 0.5,
        ks_backward_v: 0.6,
        kv_v_s_per_m: 24.0,
        ka_v_s2_per_m: 0.7,
    };
    Acting { volts: 3.0, motor }
}

fn acts(effect: &dyn MotorEffect, p: &[f64], moment: &Moment) -> Acting {
    let mut acting = acting();
    effect.act(p, moment, &mut acting);
    acting
}

/// What is wrong, and the text that it points at.
fn refused(equation: &str) -> (ExpressionProblem, String) {
    let shown = |error: ExpressionError, text: &str| {
        let pointed = text.get(error.at).unwrap_or("").to_owned();
        (error.problem, pointed)
    };
    match MotorCustom::from_equation(equation) {
        Err(error) => shown(error, equation),
        Ok(custom) => shown(custom.build().expect_err(equation), &custom.expression),
    }
}

#[test]
fn units_follow_from_the_expression() {
    let units = |equation: &str| -> Vec<String> {
        let effect = built(equation);
        effect.facts().parameters.iter().map(|parameter| parameter.unit.to_string()).collect()
    };
    assert_eq!(units("dV = q * v * abs(v)"), ["V s^2/m^2"]);
    assert_eq!(units("dkS = k * exp(-abs(v) / w)"), ["V", "m/s"]);
    assert_eq!(units("dkV_left = a * cos(3*phi) + b * sin(3*phi)"), ["V s/m", "V s/m"]);
    assert_eq!(units("dkA = k * abs(volts)"), ["s^2/m"]);
    assert_eq!(units("dkS = k * abs(load)"), ["1"]);
    assert_eq!(units("dV_right = c * t * sign(v) + g * sin(theta)"), ["V/s", "V"]);
}

#[test]
fn every_mistake_is_named_and_pointed_at() {
    for (equation, problem, pointed) in [
        ("q * v", "NoEquals", "q * v"),
        ("dtheta = k * v", r#"Target("dtheta")"#, "dtheta"),
        ("dV_both = k", r#"Target("dV_both")"#, "dV_both"),
        ("dV/dt = k", r#"Target("dV/dt")"#, "dV/dt"),
        ("dV = q * omega", r#"Reserved { name: "omega""#, "omega"),
        ("dV = kV * v", r#"Reserved { name: "kV""#, "kV"),
        ("dV = q * r * v", r#"UnknownUnit("q")"#, "q * r * v"),
        ("dV = k * (v + volts)", "WrongUnit { required: Same", "(v + volts)"),
        ("dV = k / v", "Unbounded(AtRest)", "k / v"),
        ("dV = k / volts", "Unbounded(WithoutVoltage)", "k / volts"),
        ("dV = 2 * v", "DoesNotVanish", ""),
        // So little that it is lost beside any other number, but not beside zero.
        ("dV = k * v + 1e-308[V]", "DoesNotVanish", "k * v + 1e-308[V]"),
        ("dV = k * volt", r#"LooksLike { name: "volt", variable: "volts" }"#, "volt"),
    ] {
        let (found, at) = refused(equation);
        let found = format!("{found:?}");
        assert!(found.starts_with(problem), "{equation}: {found}");
        if !pointed.is_empty() {
            assert_eq!(at, pointed, "{equation}: {found}");
        }
    }
    let taken = MotorCustom::from_equation("dV = q * v").unwrap();
    let taken = MotorCustom { id: "backlash".into(), ..taken }.build().unwrap_err();
    assert_eq!(taken.problem, ExpressionProblem::Id("backlash".into()));
}

#[test]
fn each_left_side_changes_what_it_names_of_the_motors_it_names() {
    let [left, right, backwards, _] = sample_moments();
    for equation in ["dV = k", "dkS = k", "dkV = k", "dkA = k"] {
        let effect = built(equation);
        for moment in sample_moments() {
            assert_eq!(acts(&effect, &[0.0], &moment), acting(), "{equation}");
        }
    }
    assert_eq!(acts(&built("dV = k"), &[0.2], &left).volts, 2.8);
    let friction = acts(&built("dkS = k"), &[0.2], &backwards).motor;
    assert!((friction.ks_forward_v - 0.7).abs() < 1e-12);
    assert!((friction.ks_backward_v - 0.8).abs() < 1e-12);
    // Friction never drives, inertia never vanishes.
    assert_eq!(acts(&built("dkS = k"), &[-9.0], &left).motor.ks_forward_v, 0.0);
    assert!(acts(&built("dkA = k"), &[-9.0], &left).motor.ka_v_s2_per_m > 0.03);
    assert_eq!(acts(&built("dkV = k"), &[2.0], &left).motor.kv_v_s_per_m, 26.0);
    assert_eq!(acts(&built("dV_left = k"), &[0.2], &right), acting());
    assert_eq!(acts(&built("dV_right = k"), &[0.2], &right).volts, 2.8);
    assert_eq!(acts(&built("dV_right = k"), &[0.2], &left), acting());
    // What the motor works against: 8.14 V less 24 V s/m times 0.31 m/s.
    let loaded = acts(&built("dkS = k * abs(load)"), &[0.1], &left).motor;
    assert!((loaded.ks_forward_v - 0.57).abs() < 1e-9, "{loaded:?}");
    // Where there is no value, nothing.
    let rest = Moment { speed_mps: (0.0, 0.0), ..left };
    assert_eq!(acts(&built("dV = k * v^2 / v"), &[0.2], &rest), acting());
}

/// What a built-in effect does, written as an expression: the same to rounding.
#[test]
fn an_expression_does_what_the_built_in_effect_does() {
    for (equation, id, p) in [
        ("dV = q * v * abs(v)", "quadratic_drag", [1.3]),
        ("dkS = s * exp(-(v / 0.003[m/s])^2)", "static_friction", [0.2]),
    ] {
        let (own, built_in) = (built(equation), find(id).unwrap());
        for moment in sample_moments() {
            let slow = Moment { speed_mps: (0.001, 0.0), ..moment };
            for moment in [moment, slow] {
                let (a, b) = (acts(&own, &p, &moment), acts(built_in, &p, &moment));
                assert!((a.volts - b.volts).abs() < 1e-12, "{equation}");
                let off = a.motor.ks_forward_v - b.motor.ks_forward_v;
                assert!(off.abs() < 1e-12, "{equation}");
            }
        }
    }
}

#[test]
fn usual_sizes_come_to_volts_and_shapes_are_tried_in_seven_places() {
    let effect = built("dkS = k * exp(-abs(v) / w)");
    let [k, w] = effect.facts().parameters else { panic!() };
    assert_eq!((k.role, w.role), (MotorRole::Amplitude, MotorRole::Shape));
    assert!(k.usual > 0.3 && k.usual < 1.0 && k.high / k.usual > 50.0, "{k:?}");
    let excitation =
        Excitation { speed_mps_max: 0.4, gear_reduction: 1.0, counts_per_wheel_turn: 900.0 };
    let starts = effect.starts(&excitation);
    assert!(starts.len() == 7 && starts.iter().all(|start| start[0] == 0.0), "{starts:?}");
    // What acts near rest, or at one angle only, is as large there; its shape is none of its amplitudes.
    for equation in [
        "dkS = k * exp(-(v / 0.01[m/s])^2)",
        "dkS = k * exp(-(v / 0.01[m/s])^2) * abs(sin(n * phi))",
        "dkS_right = k * exp(-((phi - 2) / 0.1)^2)",
    ] {
        let effect = built(equation);
        let [k, rest @ ..] = effect.facts().parameters else { panic!() };
        assert!(k.usual > 0.25 && k.usual < 1.5, "{equation}: {k:?}");
        assert!(rest.iter().all(|shape| shape.role == MotorRole::Shape), "{equation}: {rest:?}");
    }
    // A back-EMF constant by what it comes to at a speed.
    let constant = built("dkV = k").facts().parameters[0].usual;
    assert!((0.8..1.3).contains(&constant), "{constant}");
    let mut one_sign = MotorCustom::from_equation("dV = q * v * abs(v)").unwrap();
    one_sign.ranges.insert("q".into(), [0.0, 5.0]);
    let effect = one_sign.build().unwrap();
    let q = &effect.facts().parameters[0];
    assert_eq!((q.low, q.high), (0.0, 5.0));
    assert!(MOTOR_CATALOGUE.iter().all(|effect| effect.facts().id != "custom_dv"));
}

#[test]
fn an_equation_is_read_as_it_is_written() {
    for equation in ["dV = q * v * abs(v)", "dkS_left = a * cos(phi)", "dkA_right = k * abs(v)"] {
        let custom = MotorCustom::from_equation(equation).unwrap();
        assert_eq!(custom.equation(), equation);
    }
    assert_eq!(MotorCustom::from_equation("dkS_left = a").unwrap().id, "custom_dks_left");
    assert_eq!(
        MotorCustom::from_equation("dkS_left = a * cos(n * phi)").unwrap().parameters().unwrap(),
        ["a", "n"]
    );
}

proptest::proptest! {
    #[test]
    fn no_text_makes_the_reader_panic_and_errors_point_into_it(
        text in "dV = [kqvtsphide0-9 .+*/^()\\[\\],é-]{0,40}"
    ) {
        match MotorCustom::from_equation(&text) {
            Err(error) => proptest::prop_assert!(text.get(error.at.clone()).is_some(), "{:?}", error),
            Ok(custom) => if let Ok(effect) = custom.build() {
                let p = vec![0.0; effect.facts().parameters.len()];
                for moment in sample_moments() {
                    // Amplitudes of zero: nothing, unless a shape of zero has no value.
                    let changed = acts(&effect, &p, &moment);
                    proptest::prop_assert!(changed.volts.is_finite());
                }
            },
        }
    }
}
