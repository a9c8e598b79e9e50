//! Reads `motors.toml`, with one clear error for each way it can be wrong.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use robot_model::drivetrain::{CustomMotorEffect, KnownMotorEffect, MotorCustom, MotorEffect};
use serde::Deserialize;
use toml::Spanned;

use super::{FittedValue, MotorModelEntry, MotorModelFile};
use crate::equation_words::{About, Declaration, values};
use crate::toml_text::parse_toml;
use crate::{CampaignError, Place, bounded_read};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFile {
    #[serde(default)]
    effect: Vec<RawEffect>,
    #[serde(default)]
    custom: Vec<RawCustom>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawEffect {
    id: Spanned<String>,
    #[serde(default)]
    parameters: BTreeMap<String, Spanned<FittedValue>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCustom {
    id: Spanned<String>,
    equation: Spanned<String>,
    #[serde(default)]
    unit: BTreeMap<String, Spanned<String>>,
    #[serde(default)]
    range: BTreeMap<String, Spanned<[f64; 2]>>,
}

impl MotorModelFile {
    /// Reads a model; if the file does not exist, the model is empty.
    pub fn read_or_empty(file: &Path) -> Result<Self, CampaignError> {
        if !file.exists() {
            return Ok(Self::default());
        }
        let text = bounded_read::read_keys(file)
            .map_err(|error| CampaignError::io(file, "read it", error))?;
        Self::parse(file, &text)
    }

    /// Reads a model from its text; errors call it `file`.
    pub fn parse(file: &Path, text: &str) -> Result<Self, CampaignError> {
        let raw: RawFile = parse_toml(
            file,
            text,
            |_| "mend that line, or delete the file and begin again with `beeline model add --drivetrain`",
        )?;
        let mut model = Self::default();
        for custom in &raw.custom {
            let effect = own(custom, file, text)?;
            if model.customs.iter().any(|own| own.facts().id == effect.facts().id) {
                let place = Place::of_byte(file, text, custom.id.span().start);
                let problem = format!("the effect `{}` is declared twice", effect.facts().id);
                let hint = "choose another id, or remove one";
                return Err(CampaignError::new(place, problem, hint));
            }
            model.customs.push(Arc::new(effect));
        }
        for RawEffect { id, parameters } in raw.effect {
            let place = Place::of_byte(file, text, id.span().start);
            let name = id.into_inner();
            let Some(effect) = model.find(&name) else {
                let problem = format!("motors have no effect `{name}`");
                return Err(CampaignError::new(place, problem, model.ids()));
            };
            if model.effects.iter().any(|own| own.effect.facts().id == name) {
                let problem = format!("{name} is there twice");
                return Err(CampaignError::new(place, problem, "remove one of them"));
            }
            let values = fitted_values(&effect, parameters, file, text)?;
            model.effects.push(MotorModelEntry { effect, values });
        }
        Ok(model)
    }
}

/// The values of an effect, if they are its own and can be.
fn fitted_values(
    effect: &KnownMotorEffect,
    raw: BTreeMap<String, Spanned<FittedValue>>,
    file: &Path,
    text: &str,
) -> Result<BTreeMap<String, FittedValue>, CampaignError> {
    let facts = effect.facts();
    let mut values = BTreeMap::new();
    for (name, value) in raw {
        let place = Place::of_byte(file, text, value.span().start);
        let fail =
            |problem: String, hint: String| Err(CampaignError::new(place.clone(), problem, hint));
        let value = value.into_inner();
        let Some(known) = facts.parameters.iter().find(|known| *known.name == *name) else {
            let names: Vec<&str> = facts.parameters.iter().map(|known| &*known.name).collect();
            let problem = format!("{} has no parameter `{name}`", facts.id);
            return fail(problem, format!("it has {}", names.join(", ")));
        };
        if let Some(unit) = value.unit.as_ref().filter(|unit| **unit != *known.unit) {
            let problem = format!("{name} of {} is in {}, not in {unit}", facts.id, known.unit);
            return fail(problem, "give the value in that unit".into());
        }
        let is_width = |width: f64| width >= 0.0;
        if !value.value.is_finite() || !value.half_width_95.is_none_or(is_width) {
            let problem = format!("{name} of {} is not a number with a half-width", facts.id);
            return fail(problem, "`beeline model fit --drivetrain` fits it again".into());
        }
        values.insert(name, value);
    }
    Ok(values)
}

/// An effect of the user's own, as declared.
fn own(raw: &RawCustom, file: &Path, text: &str) -> Result<CustomMotorEffect, CampaignError> {
    let equation = raw.equation.get_ref();
    let begins = raw.equation.span().start + 1;
    let declaration = |expression: usize, expression_text| Declaration {
        about: About::Motors,
        start: raw.id.span().start,
        left_side: begins,
        expression,
        expression_text,
        unit: &raw.unit,
        range: &raw.range,
    };
    let read = MotorCustom::from_equation(equation)
        .map_err(|error| declaration(begins, equation).error(file, text, &error))?;
    let custom = MotorCustom {
        id: raw.id.get_ref().clone(),
        units: values(&raw.unit, String::clone),
        ranges: values(&raw.range, |range| *range),
        ..read
    };
    // The right side is the end of the equation.
    let before = equation.trim_end().len() - custom.expression.len();
    custom
        .build()
        .map_err(|error| declaration(begins + before, &custom.expression).error(file, text, &error))
}
