//! Reads `model.toml`, with one clear error for each way it can be wrong.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use robot_model::effect::custom::{CustomError, Part, Per, Target};
use robot_model::effect::{Custom, CustomEffect};
use toml::Spanned;

use super::raw::{RawCustom, RawEffect, RawModel};
use super::{EffectEntry, FitEntry, ModelFile, validate};
use crate::{CampaignError, Place};

impl ModelFile {
    /// Reads a model; that of a campaign without one is empty.
    pub fn read_or_empty(file: &Path) -> Result<Self, CampaignError> {
        if file.exists() { Self::read(file) } else { Ok(Self::default()) }
    }

    /// Reads a model.
    pub fn read(file: &Path) -> Result<Self, CampaignError> {
        let text =
            fs::read_to_string(file).map_err(|error| CampaignError::io(file, "read it", error))?;
        Self::parse(file, &text)
    }

    /// Reads a model from its text; `file` is for the words of an error.
    pub fn parse(file: &Path, text: &str) -> Result<Self, CampaignError> {
        let raw: RawModel = toml::from_str(text).map_err(|error| {
            let place = error
                .span()
                .map_or_else(|| Place::whole(file), |it| Place::of_byte(file, text, it.start));
            let problem = error.message().trim().replace('\n', "; ");
            CampaignError::new(place, problem, "compare with what `beeline model fit` writes")
        })?;
        let mut model = Self::default();
        for custom in &raw.custom {
            model.customs.push(Arc::new(custom_effect(custom, &model, file, text)?));
        }
        for entry in &raw.effect {
            model.effects.push(effect_entry(entry, &model, file, text)?);
        }
        let wrong = |wrong: validate::Invalid| wrong.at(file, text);
        let errors = raw.error.as_ref().map(validate::errors).transpose().map_err(wrong)?;
        let noise = raw.noise.as_ref().map(validate::noise).transpose().map_err(wrong)?;
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
        Target::ALL.into_iter().find(|it| it.name() == custom.target.get_ref()),
        Per::ALL.into_iter().find(|it| it.name() == custom.per.get_ref()),
    ) else {
        let target = Target::ALL.iter().any(|it| it.name() == custom.target.get_ref());
        let wrong = if target { &custom.per } else { &custom.target };
        let names: Vec<&str> = if target {
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
        units: map(&custom.unit, String::clone),
        ranges: map(&custom.range, |it| *it),
    };
    if model.customs.iter().any(|it| it.custom().id == declared.id) {
        let problem = format!("the effect `{}` is declared twice", declared.id);
        return fail(start, problem, "choose another id, or remove one".into());
    }
    match declared.build() {
        Ok(effect) => Ok(effect),
        Err(error) => {
            // The place in the file, as long as the string has no escapes before it.
            let inside = |it: &Spanned<String>| it.span().start + 1 + error.at.start;
            let byte = match &error.part {
                Part::Id => start,
                Part::Target => custom.target.span().start,
                Part::Expression => inside(&custom.expression),
                Part::Unit(name) => custom.unit.get(name).map_or(start, inside),
                Part::Range(name) => custom.range.get(name).map_or(start, |it| it.span().start),
            };
            let problem = match error.part {
                Part::Expression => {
                    format!("{}{}", error.problem, caret(&declared.expression, &error))
                }
                _ => error.problem,
            };
            fail(byte, problem, error.hint)
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
    if model.effects.iter().any(|it| it.effect.facts().id == id) {
        let problem = format!("the effect `{id}` appears twice");
        return fail(entry.id.span().start, problem, "remove one".into());
    }
    let known = effect.facts().parameters;
    if let Some((name, it)) =
        entry.parameters.iter().find(|(name, _)| !known.iter().any(|it| it.name == **name))
    {
        let names: Vec<&str> = known.iter().map(|it| it.name.as_ref()).collect();
        let problem = format!("{id} has no parameter `{name}`");
        return fail(it.span().start, problem, format!("it has {}", names.join(", ")));
    }
    let here = known.iter().filter_map(|it| Some((it, entry.parameters.get(it.name.as_ref())?)));
    let parameters = here
        .map(|(it, raw)| validate::parameter(id, it, raw).map_err(|wrong| wrong.at(file, text)))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(EffectEntry { effect, parameters, in_use: entry.in_use })
}

fn map<A, B>(from: &BTreeMap<String, Spanned<A>>, of: impl Fn(&A) -> B) -> BTreeMap<String, B> {
    from.iter().map(|(name, it)| (name.clone(), of(it.get_ref()))).collect()
}

/// What to try where an effect is not known: the nearest one, or all.
pub fn hint_for(id: &str, model: &ModelFile) -> String {
    let ids: Vec<&str> = model.catalogue().iter().map(|it| it.facts().id).collect();
    let beginning = |it: &&&str| !id.is_empty() && (it.contains(id) || id.contains(**it));
    match ids.iter().find(beginning) {
        Some(near) => format!("did you mean {near}?"),
        None => format!("the effects are {}", ids.join(", ")),
    }
}

/// The text with a caret under what is wrong, on lines of their own.
pub fn caret(text: &str, error: &CustomError) -> String {
    let before = text.get(..error.at.start).map_or(0, |it| it.chars().count());
    let wide = text.get(error.at.clone()).map_or(1, |it| it.chars().count()).max(1);
    format!("\n    {text}\n    {}{}", " ".repeat(before), "^".repeat(wide))
}

/// Reads an equation from a command line; the error shows it with a caret.
pub fn custom_from_equation(text: &str) -> Result<Custom, CampaignError> {
    Custom::from_equation(text).map_err(|error| equation_error(text, &error))
}

/// An error in an equation, with its column and a caret.
pub fn equation_error(text: &str, error: &CustomError) -> CampaignError {
    let column = text.get(..error.at.start).map_or(0, |it| it.chars().count()) as u64 + 1;
    let place = Place { line: 1, column, ..Place::whole(Path::new("the equation")) };
    CampaignError::new(place, format!("{}{}", error.problem, caret(text, error)), &error.hint)
}
