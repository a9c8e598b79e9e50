//! Reads `motors.toml`, with one clear error for each way it can be wrong.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use robot_model::drivetrain::{CustomMotorEffect, MotorCustom, MotorEffect};
use serde::Deserialize;
use toml::Spanned;

use super::{FittedValue, MotorModelEntry, MotorModelFile};
use crate::equation_words::{About, Declaration, values};
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
    parameters: BTreeMap<String, FittedValue>,
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
        let raw: RawFile = toml::from_str(text).map_err(|error| {
            let place = error
                .span()
                .map_or_else(|| Place::whole(file), |span| Place::of_byte(file, text, span.start));
            let problem = error.message().trim().replace('\n', "; ");
            let hint = "`beeline model fit CAMPAIGN --drivetrain` writes such a file";
            CampaignError::new(place, problem, hint)
        })?;
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
            model.effects.push(MotorModelEntry { effect, values: parameters });
        }
        Ok(model)
    }
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
