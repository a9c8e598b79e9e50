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
    let of = |it: &ModelFile| -> Vec<_> {
        it.effects.iter().map(|it| (it.effect.facts().id, it.parameters.clone())).collect()
    };
    assert_eq!(of(&model), of(&again));
    assert_eq!(again.customs[0].custom(), model.customs[0].custom());
    let assumed = again.assumed().unwrap();
    assert_eq!(assumed[1].values, [-0.5]);
    assert_eq!(model.catalogue().len(), CATALOGUE.len() + 1);
}

#[test]
fn an_effect_without_values_is_named() {
    let model = parse("[[effect]]\nid = \"side_slip\"\n").unwrap();
    assert_eq!(model.assumed().unwrap_err(), "side_slip");
}

#[test]
fn every_way_to_be_wrong_has_its_place_and_a_hint() {
    for (from, to, expected) in [
        (
            "\"side_slip\"",
            "\"side_slop\"",
            "line 3, column 6: there is no effect `side_slop`; there are",
        ),
        ("\"side_slip\"", "\"slip\"", "did you mean side_slip?"),
        (
            "parameters.k",
            "parameters.q",
            "line 4, column 16: side_slip has no parameter `q`; it has k",
        ),
        ("0.021", "nan", "line 4, column 16: k has a number that is not finite"),
        ("0.021", "\"x\"", "line 4, column 26: invalid type: string"),
        (
            "id = \"mine\"\nparam",
            "id = \"side_slip\"\nparam",
            "line 7, column 6: the effect `side_slip` is there twice",
        ),
        ("\"dtheta\"", "\"dz\"", "line 12, column 10: `dz` is not known here; one of ds_left"),
        ("\"second\"", "\"hour\"", "line 13, column 7: `hour` is not known here; one of second"),
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
