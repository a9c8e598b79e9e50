use std::path::Path;

use proptest::prelude::*;

use super::*;

const GOOD: &str = r#"
[[effect]]
id = "side_slip"
parameters.k = { value = 0.021, sigma = 0.001, unit = "s" }

[[effect]]
id = "mine"
parameters.c = { value = -0.5 }

[[custom]]
id = "mine"
target = "dtheta"
per = "second"
expression = "c * v^2 * omega"
unit.c = "s^2/m^2"
range.c = [-2, 2]
"#;

fn parse(text: &str) -> Result<ModelFile, String> {
    ModelFile::parse(Path::new("model.toml"), text).map_err(|error| error.to_string())
}

#[test]
fn what_was_written_is_read_again() {
    let model = parse(GOOD).unwrap();
    let again = parse(&model.to_text("a \n robot")).unwrap();
    // Numbers are written with six digits.
    let parameter = |of: &ParameterFound| {
        let numbers = [of.value, of.sigma, of.low95, of.high95].map(|value| format!("{value:.5e}"));
        (of.name.clone(), of.unit.clone(), numbers)
    };
    let of = |model: &ModelFile| -> Vec<_> {
        let each = model.effects.iter();
        each.map(|entry| {
            let parameters: Vec<_> = entry.parameters.iter().map(parameter).collect();
            (entry.id().to_owned(), parameters)
        })
        .collect()
    };
    assert_eq!(of(&model), of(&again));
    assert_eq!(again.customs[0].custom(), model.customs[0].custom());
    let effects = again.effects_with_values().unwrap();
    assert_eq!(effects[1].values, [-0.5]);
    assert_eq!(model.catalogue().len(), CATALOGUE.len() + 1);
    // A parameter of the user's own effect has the unit that was declared.
    let mine =
        |unit: &str| GOOD.replace("value = -0.5", &format!("value = -0.5, unit = \"{unit}\""));
    parse(&mine("s^2/m^2")).unwrap();
    assert!(parse(&mine("s")).map(|_| ()).unwrap_err().contains("has the unit s^2/m^2, not s"));
}

#[test]
fn the_speed_up_to_which_an_effect_is_known_is_kept_and_must_be_a_speed() {
    let limited = |limit: &str| {
        GOOD.replace("id = \"side_slip\"", &format!("id = \"side_slip\"\nup_to_mps = {limit}"))
    };
    let model = parse(&limited("0.11")).unwrap();
    let again = parse(&model.to_text("robot")).unwrap();
    let limits: Vec<_> =
        again.effects_with_values().unwrap().iter().map(|one| one.up_to_mps).collect();
    assert_eq!(limits, [Some(0.11), None]);
    for wrong in ["0", "-1.0", "nan", "inf"] {
        let error = parse(&limited(wrong)).map(|_| ()).unwrap_err();
        assert!(error.contains("line 4") && error.contains("up_to_mps"), "{error}");
    }
}

#[test]
fn whatever_a_fit_may_come_to_is_read_again() {
    for effect in CATALOGUE {
        let facts = effect.facts();
        for at in [0.0_f64, 0.3, 0.6, 1.0] {
            let found = |known: &robot_model::effect::Parameter| {
                let value = known.low + at * (known.high - known.low);
                let (name, unit) = (known.name.to_string(), known.unit.to_string());
                ParameterFound { name, unit, value, sigma: 0.1, low95: value, high95: value }
            };
            let mut entry = EffectEntry::unfitted(KnownEffect::BuiltIn(effect));
            entry.parameters = facts.parameters.iter().map(found).collect();
            let model = ModelFile { effects: vec![entry], ..ModelFile::default() };
            let again =
                parse(&model.to_text("r")).unwrap_or_else(|error| panic!("{}: {error}", facts.id));
            assert_eq!(again.effects[0].parameters.len(), facts.parameters.len(), "{}", facts.id);
        }
    }
}

#[test]
fn an_effect_without_values_is_named() {
    let model = parse("[[effect]]\nid = \"side_slip\"\n").unwrap();
    assert_eq!(model.effects_with_values().unwrap_err(), "side_slip");
}

#[test]
fn every_way_to_be_wrong_has_its_place_and_a_hint() {
    for (from, to, expected) in [
        (
            "\"side_slip\"",
            "\"side_slop\"",
            "line 3, column 6: there is no effect `side_slop`; the effects are",
        ),
        ("\"side_slip\"", "\"slip\"", "did you mean side_slip?"),
        (
            "parameters.k",
            "parameters.q",
            "line 4, column 16: side_slip has no parameter `q`; it has k",
        ),
        (
            "0.021",
            "nan",
            "line 4, column 26: k has a number that is not finite; remove it, and `beeline model fit",
        ),
        (
            "unit = \"s\"",
            "unit = \"ms\"",
            "line 4, column 55: k of side_slip has the unit s, not ms; give the value in s",
        ),
        ("0.001", "-0.001", "line 4, column 41: sigma = -0.001 is negative; a standard error"),
        (
            "sigma = 0.001",
            "low95 = 0.03, high95 = 0.01",
            "line 4, column 41: low95 = 0.03 lies above high95 = 0.01; swap",
        ),
        ("0.021", "\"x\"", "line 4, column 26: invalid type: string"),
        (
            "id = \"mine\"\nparam",
            "id = \"side_slip\"\nparam",
            "line 7, column 6: the effect `side_slip` appears twice",
        ),
        ("\"dtheta\"", "\"dz\"", "line 12, column 10: `dz` is unknown here; one of ds_left"),
        ("\"second\"", "\"hour\"", "line 13, column 7: `hour` is unknown here; one of second"),
        (
            "v^2",
            "v^^2",
            "line 14, column 21: `^` cannot stand here\n    c * v^^2 * omega\n          ^;",
        ),
        ("\"s^2/m^2\"", "\"s^2/mm^2\"", "`mm` is not an SI base unit"),
        ("\"s^2/m^2\"", "\"s\"", "line 14, column 15: dtheta per second has the unit 1/s"),
        ("[-2, 2]", "[2, -2]", "line 16, column 11: 2 to -2 cannot be the range of c"),
        ("range.c", "range.d", "line 16, column 11: the expression has no parameter `d`; it has c"),
        ("[[effect]]", "[[efect]]", "unknown field `efect`"),
        ("target = \"dtheta\"\n", "", "missing field `target`"),
    ] {
        assert!(GOOD.contains(from), "{from}");
        let error = parse(&GOOD.replacen(from, to, 1)).map(|_| ()).unwrap_err();
        assert!(error.contains(expected), "{error}\n  does not say: {expected}");
    }
}

/// A parameter that makes no sense, in an effect of its own.
#[test]
fn what_no_robot_has_is_refused_and_what_is_merely_implausible_is_not() {
    let effect = |id: &str, parameters: &[(&str, &str)]| {
        let line =
            |(name, value): &(&str, &str)| format!("parameters.{name} = {{ value = {value} }}\n");
        parse(&format!(
            "[[effect]]\nid = \"{id}\"\n{}",
            parameters.iter().map(line).collect::<String>()
        ))
    };
    for (id, name, value, must) in [
        ("track_width", "delta", "-1", "above -1"),
        ("wheel_radius_scale", "s", "-1.5", "above -1"),
        ("wheel_radius_ratio", "rho", "2", "between -2 and 2"),
        ("turn_asymmetry", "k", "-1", "between -1 and 1"),
        ("caster_kick", "length", "0", "above zero"),
        ("caster_kick", "length", "-0.05", "above zero"),
    ] {
        let error = effect(id, &[(name, value)]).map(|_| ()).unwrap_err();
        let column = format!("parameters.{name} = {{ value = ").len() + 1;
        let place = format!("line 3, column {column}: {name} = {value} is impossible");
        assert!(error.contains(&place) && error.contains(must), "{error}");
    }
    // Far beyond what is plausible, as a fit to odd runs may have it.
    let odd = [
        ("track_width", "delta", "-0.5"),
        ("caster_kick", "length", "3"),
        ("backlash", "beta_left", "-0.1"),
    ];
    for (id, name, value) in odd {
        effect(id, &[(name, value)]).unwrap();
    }
}

#[test]
fn errors_and_noise_are_sizes() {
    let fit = FitEntry {
        runs: 3,
        nominal: ErrorPair { fitted: errors(1.0), cross_validated: errors(2.0) },
        errors: ErrorPair { fitted: errors(3.0), cross_validated: errors(4.0) },
        noise: OdometryNoise::TYPICAL,
    };
    let text = ModelFile { fit: Some(fit), ..parse(GOOD).unwrap() }.to_text("robot");
    assert_eq!(parse(&text).unwrap().fit.unwrap().errors, fit.errors);
    // As version 0.1.0 wrote them.
    let old = text.replace("cross_validated = ", "heldout = ");
    assert!(old.contains("nominal_heldout = ") && old.contains("\nheldout = "), "{old}");
    assert_eq!(parse(&old).unwrap().fit.unwrap().errors, fit.errors);
    let lines = || text.lines().enumerate().skip_while(|(_, line)| !line.starts_with("[error]"));
    let mut changed = 0;
    for (index, line) in lines() {
        for name in
            ["position_rms_m", "heading_rms_rad", "chi", "_sigma_m", "_walk", "_s", "_wobble_rad"]
        {
            for bad in ["-0.5", "nan", "inf"] {
                let Some((before, after)) = line.split_once(&format!("{name} = ")) else {
                    continue;
                };
                let rest =
                    after.trim_start_matches(|c: char| c.is_ascii_digit() || ".e-".contains(c));
                let wrong = text.replace(line, &format!("{before}{name} = {bad}{rest}"));
                let error = parse(&wrong).map(|_| ()).unwrap_err();
                let column = before.len() + name.len() + 4;
                let place = format!("line {}, column {column}: ", index + 1);
                assert!(error.contains(&place) && error.contains("not negative"), "{error}");
                changed += 1;
            }
        }
    }
    assert!(changed >= 3 * (12 + 6), "{changed}");
}

fn errors(size: f64) -> robot_model::estimation::Errors {
    robot_model::estimation::Errors { position_rms_m: size, heading_rms_rad: 2.0 * size, chi: 1.5 }
}

proptest! {
    #[test]
    fn mangled_models_are_refused_or_read_but_never_panic(
        cut in 0_usize..400, length in 0_usize..40, put in "[ -~\\n\u{e9}]{0,12}",
    ) {
        let mut text: Vec<char> = GOOD.chars().collect();
        let from = cut.min(text.len());
        let to = (from + length).min(text.len());
        text.splice(from..to, put.chars());
        let text: String = text.into_iter().collect();
        if let Err(error) = ModelFile::parse(Path::new("model.toml"), &text) {
            prop_assert!(!error.hint.is_empty() && !error.problem.is_empty());
        }
    }
}
