//! Reads `model.toml`, with one clear error for each way it can be wrong.

use std::path::Path;
use std::sync::Arc;

use robot_model::effect::custom::{Per, Target};
use robot_model::effect::{Custom, CustomEffect};
use robot_model::expression::ExpressionError;

use super::unchecked::{RawCustom, RawEffect, RawModel};
use super::{EffectEntry, FitEntry, ModelFile, validate};
use crate::equation_words::{About, Declaration, values};
use crate::toml_text::parse_toml;
use crate::{CampaignError, Place, bounded_read};

impl ModelFile {
    /// Reads a model; if the file does not exist, the model is empty.
    pub fn read_or_empty(file: &Path) -> Result<Self, CampaignError> {
        if file.exists() { Self::read(file) } else { Ok(Self::default()) }
    }

    /// Reads a model.
    pub fn read(file: &Path) -> Result<Self, CampaignError> {
        let text = bounded_read::read_keys(file)
            .map_err(|error| CampaignError::io(file, "read it", error))?;
        Self::parse(file, &text)
    }

    /// Reads a model from its text; errors call it `file`.
    pub fn parse(file: &Path, text: &str) -> Result<Self, CampaignError> {
        let raw: RawModel =
            parse_toml(file, text, |_| "`beeline model fit` writes such a file: compare with one")?;
        let mut model = Self::default();
        for custom in &raw.custom {
            model.customs.push(Arc::new(custom_effect(custom, &model, file, text)?));
        }
        for entry in &raw.effect {
            model.effects.push(effect_entry(entry, &model, file, text)?);
        }
        let placed = |invalid: validate::Invalid| invalid.at(file, text);
        let errors = raw.error.as_ref().map(validate::errors).transpose().map_err(placed)?;
        let noise = raw.noise.as_ref().map(validate::noise).transpose().map_err(placed)?;
        model.fit = errors.zip(noise).map(|((runs, nominal, errors), noise)| FitEntry {
            runs,
            nominal,
            errors,
            noise,
        });
        Ok(model)
    }
}

/// An effect of the user's own, as declared.
fn custom_effect(
    custom: &RawCustom,
    model: &ModelFile,
    file: &Path,
    text: &str,
) -> Result<CustomEffect, CampaignError> {
    let fail = |byte: usize, problem: String, hint: String| {
        Err(CampaignError::new(Place::of_byte(file, text, byte), problem, hint))
    };
    let start = custom.id.span().start;
    let (Some(target), Some(per)) = (
        Target::ALL.into_iter().find(|target| target.name() == custom.target.get_ref()),
        Per::ALL.into_iter().find(|per| per.name() == custom.per.get_ref()),
    ) else {
        let target_is_known =
            Target::ALL.iter().any(|target| target.name() == custom.target.get_ref());
        let wrong = if target_is_known { &custom.per } else { &custom.target };
        let names: Vec<&str> = if target_is_known {
            Per::ALL.map(Per::name).into()
        } else {
            Target::ALL.map(Target::name).into()
        };
        let problem = format!("`{}` is unknown here", wrong.get_ref());
        return fail(wrong.span().start, problem, format!("one of {}", names.join(", ")));
    };
    let declared = Custom {
        id: custom.id.get_ref().clone(),
        target,
        per,
        expression: custom.expression.get_ref().clone(),
        units: values(&custom.unit, String::clone),
        ranges: values(&custom.range, |range| *range),
    };
    if model.customs.iter().any(|own| own.custom().id == declared.id) {
        let problem = format!("the effect `{}` is declared twice", declared.id);
        return fail(start, problem, "choose another id, or remove one".into());
    }
    match declared.build() {
        Ok(effect) => Ok(effect),
        Err(error) => {
            let declaration = Declaration {
                about: About::Path,
                start,
                left_side: custom.target.span().start,
                expression: custom.expression.span().start + 1,
                expression_text: &declared.expression,
                unit: &custom.unit,
                range: &custom.range,
            };
            Err(declaration.error(file, text, &error))
        }
    }
}

/// An effect of the model, with its values.
fn effect_entry(
    entry: &RawEffect,
    model: &ModelFile,
    file: &Path,
    text: &str,
) -> Result<EffectEntry, CampaignError> {
    let fail = |byte: usize, problem: String, hint: String| {
        Err(CampaignError::new(Place::of_byte(file, text, byte), problem, hint))
    };
    let id = entry.id.get_ref();
    let Some(effect) = model.find(id) else {
        let problem = format!("there is no effect `{id}`");
        return fail(entry.id.span().start, problem, hint_for(id, model));
    };
    if model.effects.iter().any(|entry| entry.effect.facts().id == id) {
        let problem = format!("the effect `{id}` appears twice");
        return fail(entry.id.span().start, problem, "remove one".into());
    }
    let known = effect.facts().parameters;
    let is_known = |name: &str| known.iter().any(|parameter| parameter.name == name);
    if let Some((name, unknown)) = entry.parameters.iter().find(|(name, _)| !is_known(name)) {
        let names: Vec<&str> = known.iter().map(|parameter| parameter.name.as_ref()).collect();
        let problem = format!("{id} has no parameter `{name}`");
        return fail(unknown.span().start, problem, format!("it has {}", names.join(", ")));
    }
    let given = known
        .iter()
        .filter_map(|parameter| Some((parameter, entry.parameters.get(parameter.name.as_ref())?)));
    let parameters = given
        .map(|(parameter, raw)| {
            validate::parameter(id, parameter, raw).map_err(|invalid| invalid.at(file, text))
        })
        .collect::<Result<Vec<_>, _>>()?;
    let up_to_mps = entry.up_to_mps.as_ref().map(validate::speed_limit).transpose();
    let up_to_mps = up_to_mps.map_err(|invalid| invalid.at(file, text))?;
    Ok(EffectEntry { effect, parameters, in_use: entry.in_use, up_to_mps })
}

/// What to try where an effect is unknown: the nearest id, or all ids.
pub fn hint_for(id: &str, model: &ModelFile) -> String {
    let ids: Vec<&str> = model.catalogue().iter().map(|effect| effect.facts().id).collect();
    let is_near = |known: &&&str| !id.is_empty() && (known.contains(id) || id.contains(**known));
    match ids.iter().find(is_near) {
        Some(near) => format!("did you mean {near}?"),
        None => format!("the effects are {}", ids.join(", ")),
    }
}

/// Reads an equation from a command line; the error shows it with a caret.
pub fn custom_from_equation(text: &str) -> Result<Custom, CampaignError> {
    Custom::from_equation(text).map_err(|error| equation_error(text, &error))
}

/// An error in an equation, with its column and a caret.
pub fn equation_error(text: &str, error: &ExpressionError) -> CampaignError {
    About::Path.error(text, error)
}
