use std::path::Path;

use robot_model::drivetrain::{ChosenEffect, ChosenModel, Estimate, MotorEffect, MotorErrors};

use super::write::text;
use super::*;

fn parsed(text: &str) -> Result<MotorModelFile, CampaignError> {
    MotorModelFile::parse(Path::new("motors.toml"), text)
}

#[test]
fn what_is_written_is_read_again() {
    let mut model = MotorModelFile::default();
    let mut custom = MotorCustom::from_equation("dkS_right = k * max(0, cos(n * phi))").unwrap();
    custom.id = "rubs".into();
    custom.ranges.insert("n".into(), [0.5, 12.0]);
    model.declare(&custom).unwrap();
    custom.id = "rubs".into();
    // The id is taken.
    let second = model.declare(&custom).unwrap();
    assert_eq!(second.facts().id, "rubs_2");
    let parameters = vec![Estimate {
        name: "k".into(),
        unit: "V".into(),
        value: 0.2,
        half_width_95: f64::INFINITY,
        is_at_end: false,
    }];
    let errors = MotorErrors { fitted_m: 0.0, cross_validated_m: 0.0, held_out_m: None };
    let effect = ChosenEffect {
        effect: model.find("rubs").unwrap(),
        parameters,
        matters: true,
        p_value: 0.0,
        without_m: 0.0,
    };
    let fitted = ChosenModel {
        errors,
        constants: Vec::new(),
        effects: vec![effect],
        each_m: Vec::new(),
        resolution_m: 0.0,
    };
    let written = text("a \"robot\"\nof two lines", &model.customs, &fitted);
    let again = parsed(&written).unwrap_or_else(|error| panic!("{error}\n{written}"));
    let ids: Vec<&str> = again.customs.iter().map(|own| own.facts().id).collect();
    assert_eq!(ids, ["rubs", "rubs_2"], "{written}");
    for (one, other) in model.customs.iter().zip(&again.customs) {
        let (one, other) = (one.facts(), other.facts());
        assert_eq!((one.equation, one.parameters), (other.equation, other.parameters));
    }
    let [entry] = again.effects.as_slice() else { panic!("{written}") };
    assert_eq!(entry.effect.facts().id, "rubs");
    assert_eq!((entry.values["k"].value, entry.values["k"].unit.as_deref()), (0.2, Some("V")));
    assert!(entry.values["k"].half_width_95.is_none());
    assert_eq!(again.catalogue().len(), 15);
}

#[test]
fn what_is_wrong_is_named_with_its_place() {
    let custom = |rest: &str| format!("[[custom]]\nid = \"own\"\n{rest}\n");
    let backlash = |rest: &str| format!("[[effect]]\nid = \"backlash\"\nparameters.{rest}\n");
    for (text, told) in [
        (
            backlash("play = { value = 1 }"),
            "motors.toml, line 3, column 19: backlash has no parameter",
        ),
        (
            backlash("beta = { value = 0.001, unit = \"mm\" }"),
            "motors.toml, line 3, column 19: beta of backlash is in m, not in mm",
        ),
        (
            backlash("beta = { value = 0.001, half_width_95 = -1 }"),
            "motors.toml, line 3, column 19: beta of backlash is not",
        ),
        (
            custom("equation = \"dV = k * (v + volts)\""),
            "motors.toml, line 3, column 22: these two have diff",
        ),
        (
            custom("equation = \"dV = k v\""),
            "motors.toml, line 3, column 20: `v` cannot stand here",
        ),
        (
            custom("equation = \"dW = k * v\""),
            "motors.toml, line 3, column 13: `dW` cannot be changed",
        ),
        (
            custom("equation = \"dV = k * v\"\nunit.q = \"V\""),
            "motors.toml, line 4, column 11: the expression has no",
        ),
        (
            custom("equation = \"dV = k * v\"\nunit.k = \"V\""),
            "motors.toml, line 3, column 18: dV has the unit V",
        ),
        (
            custom("equation = \"dV = k * v\"\nrange.k = [1, 2]"),
            "motors.toml, line 4, column 11: 1 to 2 cannot",
        ),
        (custom("target = \"dV\""), "motors.toml, line 3, column 1: unknown field"),
        (
            "[[custom]]\nid = \"backlash\"\nequation = \"dV = k * v\"".into(),
            "motors.toml, line 2, column 6: `backlash` cannot be the id",
        ),
        (
            custom("equation = \"dV = k * v\"").repeat(2),
            "motors.toml, line 5, column 6: the effect `own` is declared twice",
        ),
        (
            "[[effect]]\nid = \"own\"".into(),
            "motors.toml, line 2, column 6: motors have no effect `own`",
        ),
    ] {
        let found = parsed(&text).expect_err(&text).to_string();
        assert!(found.starts_with(told), "{text}\n{found}");
    }
}
