use super::analysis::sample_steps;
use super::variables::{NAMES, value};
use super::*;
use crate::effect::CATALOGUE;
use crate::effect::definition::{Effect, Memory, Role};
use crate::explain::explanation::explain_with;
use crate::explain::model;
use crate::expression::{
    DefinitionPart, ExpressionError, ExpressionProblem, RequiredLeftSide, RequiredUnit, Unit,
    evaluate, parse,
};
use crate::kinematics::WheelPair;
use crate::numeric::Jet;
use crate::tests::synthetic::{campaign, full_plan, term};

fn built(equation: &str) -> CustomEffect {
    Custom::from_equation(equation).unwrap().build().unwrap()
}

/// What is wrong, and the text that it points at.
fn refused(equation: &str) -> (ExpressionProblem, String) {
    let shown = |error: ExpressionError, text: &str| {
        let pointed = text.get(error.at).unwrap_or("").to_owned();
        (error.problem, pointed)
    };
    match Custom::from_equation(equation) {
        Err(error) => shown(error, equation),
        Ok(custom) => shown(custom.build().expect_err(equation), &custom.expression),
    }
}

fn units(equation: &str) -> Vec<String> {
    built(equation).facts().parameters.iter().map(|parameter| parameter.unit.to_string()).collect()
}

#[test]
fn units_of_parameters_follow_from_the_expression() {
    assert_eq!(units("dtheta = k * v^2 * omega"), ["s^2/m^2"]);
    assert_eq!(units("dn = -k * v * omega"), ["s"]);
    assert_eq!(units("dtheta/ds = c"), ["1/m"]);
    assert_eq!(units("ds_left/ds = -c * a_left * sign(v)"), ["s^2/m"]);
    assert_eq!(units("dtheta/ds = k * exp(-s / l)"), ["1/m", "m"]);
    assert_eq!(units("ds_right/ds = k * max(0, v_right - v0) / v0"), ["1", "m/s"]);
    assert_eq!(units("dtheta/ds = k * max(0[m/s], v - 0.3[m/s])"), ["s/m^2"]);
    assert_eq!(units("dn/ds = k * sqrt(payload) + c * t"), ["1/kg^0.5", "1/s"]);
    assert_eq!(units("dtheta/dtheta = c1*cos(2*theta) + s1*sin(2*theta)"), ["1", "1"]);
}

#[test]
fn an_expression_that_stays_finite_when_the_robot_stands_is_accepted() {
    for equation in [
        "dtheta/ds = k / v",
        "dtheta = k / max(abs(v), 0.02[m/s])",
        "dn/ds = k * max(0[m/s], 0.1[m/s] - v)",
        "dtheta = k * omega / v * a",
        "dtheta = k * exp(-v / v0)",
        "dn = k * sign(v)",
    ] {
        built(equation);
    }
}

#[test]
fn every_mistake_is_named_and_pointed_at() {
    for (equation, problem, pointed) in [
        ("k * v", "NoEquals", "k * v"),
        ("dx = k * v", r#"Target("dx")"#, "dx"),
        ("dtheta/dv = k", r#"Target("dtheta/dv")"#, "dtheta/dv"),
        ("dtheta = ", "EndsEarly", ""),
        ("dtheta = k * (v + 1", "OpenParenthesis", "("),
        ("dtheta = k * v) ", "ClosesNothing", ")"),
        ("dtheta = k v", "Unexpected { found: 'v', expected: Operator }", "v"),
        ("dtheta = k * (v v)", "Unexpected { found: 'v', expected: OperatorOrClose }", "v"),
        ("dtheta = k * §", "Unexpected { found: '§', expected: Operand }", "§"),
        ("dtheta = 2k", "NoOperator", "k"),
        ("dtheta = k ** 2", "DoubleStar", "*"),
        ("dtheta = k * sine(theta)", r#"NoFunction { name: "sine""#, "sine"),
        ("dtheta = k * sin", r#"NotCalled("sin")"#, "sin"),
        ("dtheta = k * max(v)", r#"Arguments { function: "max", takes: 2, found: 1 }"#, "max"),
        ("dtheta = k * v(2)", r#"VariableCalled("v")"#, "v"),
        ("dtheta = k * omga", r#"LooksLike { name: "omga", variable: "omega" }"#, "omga"),
        ("dtheta = k1+k2+k3+k4+k5", r#"TooManyParameters { name: "k5", most: 4 }"#, "k5"),
        ("dtheta = k * (v + omega)", "WrongUnit { required: Same", "(v + omega)"),
        ("dtheta = k * sin(v)", r#"WrongUnit { required: Argument("sin")"#, "v"),
        ("dtheta = k * 2^v", "WrongUnit { required: Exponent", "v"),
        ("dtheta = v * omega", "DoesNotVanish", ""),
        ("dtheta = omega * (1 + k)", "DoesNotVanish", "omega * (1 + k)"),
        ("dtheta = k / v", "Unbounded(AtRest)", "k / v"),
        ("ds_left/ds = k * a / omega^2", "Unbounded(AtRest)", "k * a / omega^2"),
        ("dn = k / a", "Unbounded(AtConstantSpeed)", "k / a"),
        ("dtheta = k * 3[furlong]", r#"NotAUnit("furlong")"#, "[furlong]"),
        ("dtheta = k * 3[mm]", r#"NotAnSiBaseUnit("mm")"#, "[mm]"),
        ("dtheta = k1 * k2 * v", r#"UnknownUnit("k1")"#, "k1 * k2 * v"),
    ] {
        let (found, at) = refused(equation);
        let found = format!("{found:?}");
        assert!(found.starts_with(problem), "{equation}: {found}");
        // An equation without a parameter is wrong as a whole.
        if !pointed.is_empty() {
            assert_eq!(at, pointed, "{equation}: {found}");
        }
    }
    let deep = format!("dtheta = {}k{}", "(".repeat(5000), ")".repeat(5000));
    assert_eq!(refused(&deep).0, ExpressionProblem::TooDeep);
}

#[test]
fn a_chain_too_long_for_the_stack_is_refused() {
    for operator in ["+", "*", "-", "/"] {
        let chain = vec!["k"; 100_000].join(operator);
        assert_eq!(refused(&format!("dtheta = {chain}")).0, ExpressionProblem::TooLong(1000));
    }
    let long = vec!["k"; 400].join("+");
    assert_eq!(units(&format!("dtheta/ds = {long}")), ["1/m"]);
}

#[test]
fn a_unit_with_a_fraction_of_a_power_is_read_as_it_is_written() {
    for equation in [
        "dn/ds = k * sqrt(payload)",
        "dtheta/ds = k * v ^ 1.5",
        "dtheta = k * abs(v) ^ (1/3)",
        "dtheta/ds = k * sqrt(a) * sqrt(payload)",
    ] {
        let mut custom = Custom::from_equation(equation).unwrap();
        let unit = custom.build().unwrap().facts().parameters[0].unit.to_string();
        custom.units.insert("k".into(), unit.clone());
        let again = custom.build().map(|effect| effect.facts().parameters[0].unit.to_string());
        assert_eq!(again, Ok(unit), "{equation}");
    }
    // An exponent of many digits.
    let mut custom = Custom::from_equation("dtheta = k * tanh(w^7 * v)").unwrap();
    let unit = custom.build().unwrap().facts().parameters[1].unit.to_string();
    assert_eq!(unit, "s^0.142857143/m^0.142857143");
    custom.units.insert("w".into(), unit.clone());
    assert_eq!(custom.build().unwrap().facts().parameters[1].unit, unit);
    // Nothing that could not be written down.
    let problem = |equation: &str| {
        let built = Custom::from_equation(equation).and_then(|custom| custom.build().map(drop));
        built.unwrap_err().problem
    };
    let too_large = ExpressionProblem::ExponentTooLarge;
    assert_eq!(problem("dtheta/dt = k * t^-65536"), too_large(-65536.0));
    assert_eq!(problem("dtheta/dt = k * t^65536"), too_large(65536.0));
    let unit = ExpressionProblem::NotAUnit("s^179".into());
    assert_eq!(problem("dtheta/dt = k * t^-90 * t^-90"), unit);
    for power in ["nan", "inf", "1e3", "1000", "", "1.2.3"] {
        assert!(Unit::parse(&format!("m^{power}")).is_err(), "{power}");
    }
}

#[test]
fn a_declared_unit_is_checked_against_the_expression() {
    let mut custom = Custom::from_equation("dtheta = k * v^2 * omega").unwrap();
    custom.units.insert("k".into(), "s^2/m^2".into());
    assert_eq!(custom.build().unwrap().facts().parameters[0].unit, "s^2/m^2");
    custom.units.insert("k".into(), "s/m".into());
    let error = custom.build().unwrap_err();
    let ExpressionProblem::WrongUnit { required, factor } = error.problem else {
        panic!("{error:?}")
    };
    let (quantity, per, unit) = ("dtheta", Some("second"), "1/s".into());
    let left_side = RequiredUnit::LeftSide(Box::new(RequiredLeftSide { quantity, per, unit }));
    assert_eq!((required, &*factor), (left_side, "m/s"));
    custom.units = [("c".to_owned(), "s".to_owned())].into();
    assert_eq!(custom.build().unwrap_err().part, DefinitionPart::Unit("c".into()));
}

#[test]
fn amplitudes_are_told_from_shapes() {
    let roles = |equation: &str| -> Vec<Role> {
        built(equation).facts().parameters.iter().map(|parameter| parameter.role).collect()
    };
    use Role::{Amplitude, Shape};
    assert_eq!(roles("dtheta/ds = k * exp(-s / l)"), [Amplitude, Shape]);
    assert_eq!(roles("dtheta/ds = k * (v - v0)"), [Amplitude, Shape]);
    assert_eq!(roles("ds_left/ds = c * cos(phi_left) + s1 * sin(phi_left)"), [Amplitude; 2]);
    assert_eq!(roles("dn = a1 * v * abs(omega / 1[rad/s]) ^ n"), [Amplitude, Shape]);
}

#[test]
fn derivatives_agree_with_differences_of_sixth_order() {
    for equation in [
        "dtheta/ds = k * exp(-s / l) + c * tanh(v / 0.2[m/s])",
        "ds_right/ds = k * max(0, v_right - v0) / v0",
        "dn = k * sin(2*theta + p) * abs(v) ^ 1.5",
        "dtheta/ds = k * cos(phi_left) / (1 + q * payload) - sqrt(abs(k * w))",
        "dtheta/ds = k * ln(2 + s/l) * abs(v_left/v_right)^n * min(a_left/0.2[m/s^2], 1) * tan(0.1*theta)",
    ] {
        let (tree, names) = parse(equation.split_once('=').unwrap().1, NAMES).unwrap();
        for step in sample_steps() {
            let at = [0.83, 0.31, 0.57, 1.71];
            let exact = evaluate(&tree, &Jet::parameters(&at), &|index| value(index, &step));
            for j in 0..names.len() {
                let value = |shift: f64| {
                    let mut at = at;
                    at[j] += shift;
                    evaluate(&tree, &Jet::parameters(&at), &|index| value(index, &step)).value
                };
                let h = 1e-3;
                let by = [(1.0, 0.75), (2.0, -0.15), (3.0, 1.0 / 60.0)];
                let difference: f64 =
                    by.iter().map(|(n, w)| w * (value(n * h) - value(-n * h)) / h).sum();
                // h^6 and rounding / h, times numbers of size ten.
                let tolerance = 1e-10 * (1.0 + exact.by[j].abs());
                assert!((difference - exact.by[j]).abs() < tolerance, "{equation}: {j}");
            }
        }
    }
}

#[test]
fn at_zero_it_is_the_identity() {
    let effect = built("ds_left = c * v_left * abs(omega) + k * a_left / 0.5[m/s^2] * v_left");
    for step in sample_steps() {
        let zero = effect.act(&Jet::parameters(&[0.0, 0.0]), &step, &mut Memory::default());
        let value = |jet: Jet| jet.value;
        assert_eq!(zero.angle_rad.map(value), WheelPair::both(0.0));
    }
}

#[test]
fn an_expression_gives_the_same_fit_as_the_built_in_effect() {
    // side_slip as an expression: the same fit, within the tolerance of Gauss-Newton.
    let runs = campaign(&full_plan(), &[term("side_slip", &[0.03])], 3);
    let own = model::fit(&runs, &[&built("dn = -k * v * omega")]).unwrap();
    let built_in = model::fit(&runs, &[crate::effect::find("side_slip").unwrap()]).unwrap();
    let (a, b) = (&own.effects[0].parameters[0], &built_in.effects[0].parameters[0]);
    // v omega dt by smoothed speeds, against v dtheta by counts: the difference is far below sigma.
    assert!((a.value - b.value).abs() < b.sigma && (a.sigma / b.sigma - 1.0).abs() < 0.05);
    let close =
        own.errors.cross_validated.position_rms_m / built_in.errors.cross_validated.position_rms_m;
    assert!((close - 1.0).abs() < 0.01, "{close}");
}

#[test]
fn explain_names_an_effect_of_the_users_own_that_the_catalogue_lacks() {
    // The catalogue without its load transfer, and an expression for it.
    let truth = [term("turn_load_transfer", &[0.06])];
    let runs = campaign(&full_plan(), &truth, 4);
    let effect = built("dtheta = -k * v^2 * omega");
    let rest = CATALOGUE.into_iter().filter(|effect| effect.facts().id != "turn_load_transfer");
    let catalogue: Vec<&dyn Effect> = rest.chain([&effect as &dyn Effect]).collect();
    let answer = explain_with(&runs, &catalogue).unwrap();
    let found: Vec<&str> = answer.steps.iter().map(|step| step.effect.as_str()).collect();
    assert_eq!(found, ["custom_dtheta"]);
    let k = &answer.steps[0].parameters[0];
    assert!((k.value - 0.06).abs() < 3.0 * k.sigma, "{k:?}");
}

#[test]
fn numbers_and_units_without_a_plausible_value_are_refused_with_their_place() {
    for text in [
        // The slope underflows, overflows, or is so small that its reciprocal overflows.
        "dtheta = k*ln(t_run*ln(0+abs(he-1e308)))*sign(v)*min(v, v)",
        "dtheta = k * v * 1e-200 * 1e-120",
        "dtheta = k * v * 1e-300",
        "dtheta = k * v * 1e300",
        "dn = k * exp(-abs(v)/c) * v^99.9 * v^99.9 * v^99.9 * v^99.9 * v^99.9 * v^99.9 * v^99.9",
    ] {
        let custom = Custom::from_equation(text).unwrap();
        match custom.build() {
            Ok(effect) => {
                for parameter in effect.facts().parameters {
                    let ends = [parameter.low, parameter.high];
                    assert!(ends.iter().all(|end| end.is_finite()), "{text}: {parameter:?}");
                    assert!(ends.iter().all(|end| end.abs() < 1e101), "{text}: {parameter:?}");
                    assert!(parameter.low < parameter.high, "{text}: {parameter:?}");
                }
            }
            Err(error) => assert!(custom.expression.get(error.at.clone()).is_some(), "{error:?}"),
        }
    }
    let refused = Custom::from_equation("dtheta = k * v * 1e-300").unwrap().build().unwrap_err();
    assert_eq!(refused.problem, ExpressionProblem::NoPlausibleValue("k".to_owned()));
}

proptest::proptest! {
    #[test]
    fn no_text_makes_the_reader_panic(text in "[a-z0-9 .+*/^()\\[\\],=é_-]{0,60}") {
        if let Ok(custom) = Custom::from_equation(&text) {
            let _ = custom.build();
        }
    }

    #[test]
    fn an_error_points_into_the_text(text in "dtheta = [kvse0-9 .+*/^()\\[\\],é-]{0,40}") {
        if let Err(error) = Custom::from_equation(&text) {
            proptest::prop_assert!(text.get(error.at.clone()).is_some(), "{:?}", error);
        }
    }
}
