//! `motors.toml`: the effects that a user has put into the model of the motors, with the values that were fitted last.
//!
//! ```toml
//! [[effect]]
//! id = "backlash"
//! parameters.play = { value = 0.0011, half_width_95 = 0.0002, unit = "m" }
//! ```
//!
//! The ids make the model. Whoever uses it fits the values to the experiments at hand.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use robot_model::drivetrain::{ChosenModel, MOTOR_CATALOGUE, MotorEffect, find_effect};
use serde::Deserialize;
use toml::Spanned;

use crate::file::write_own;
use crate::{CampaignError, Place, bounded_read};

/// A model of the motors as in `motors.toml`.
#[derive(Clone, Debug, Default)]
pub struct MotorModelFile {
    /// The effects, in their order.
    pub effects: Vec<MotorModelEntry>,
}

/// One effect.
#[derive(Clone, Debug)]
pub struct MotorModelEntry {
    /// The effect.
    pub effect: &'static dyn MotorEffect,
    /// Its values when it was fitted last, by name; empty before.
    pub values: BTreeMap<String, FittedValue>,
}

/// The value of a parameter.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FittedValue {
    /// The value.
    pub value: f64,
    /// Half the width of its 95 % interval.
    pub half_width_95: f64,
    /// Its unit; `1` for a ratio.
    pub unit: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFile {
    #[serde(default)]
    effect: Vec<RawEffect>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawEffect {
    id: Spanned<String>,
    #[serde(default)]
    parameters: BTreeMap<String, FittedValue>,
}

impl MotorModelFile {
    /// The file with the model of a campaign's motors.
    pub fn place(campaign: &Path) -> PathBuf {
        campaign.join("motors.toml")
    }

    /// The effects alone.
    pub fn chosen(&self) -> Vec<&'static dyn MotorEffect> {
        self.effects.iter().map(|entry| entry.effect).collect()
    }

    /// Reads a model; if the file does not exist, the model is empty.
    pub fn read_or_empty(file: &Path) -> Result<Self, CampaignError> {
        if !file.exists() {
            return Ok(Self::default());
        }
        let text = bounded_read::read_keys(file)
            .map_err(|error| CampaignError::io(file, "read it", error))?;
        let raw: RawFile = toml::from_str(&text).map_err(|error| {
            let place = error
                .span()
                .map_or_else(|| Place::whole(file), |span| Place::of_byte(file, &text, span.start));
            let problem = error.message().trim().replace('\n', "; ");
            let hint = "`beeline model fit CAMPAIGN --drivetrain` writes such a file";
            CampaignError::new(place, problem, hint)
        })?;
        let mut model = Self::default();
        for RawEffect { id, parameters } in raw.effect {
            let place = Place::of_byte(file, &text, id.span().start);
            let name = id.into_inner();
            let Some(effect) = find_effect(&name) else {
                let problem = format!("motors have no effect `{name}`");
                return Err(CampaignError::new(place, problem, one_of_the_catalogue()));
            };
            if model.effects.iter().any(|own| own.effect.facts().id == name) {
                let problem = format!("{name} is there twice");
                return Err(CampaignError::new(place, problem, "remove one of them"));
            }
            model.effects.push(MotorModelEntry { effect, values: parameters });
        }
        Ok(model)
    }

    /// Writes a model that was fitted.
    pub fn write(file: &Path, robot: &str, model: &ChosenModel) -> Result<(), CampaignError> {
        write_own(file, text(robot, model).as_bytes()).map_err(|error| {
            let problem = format!("cannot write it ({error})");
            let hint = error.hint("check the path and the disk");
            CampaignError::new(Place::whole(file), problem, hint)
        })
    }
}

/// What to say of an effect that there is not.
pub fn one_of_the_catalogue() -> String {
    let ids: Vec<&str> = MOTOR_CATALOGUE.iter().map(|effect| effect.facts().id).collect();
    format!("one of {}", ids.join(", "))
}

fn text(robot: &str, model: &ChosenModel) -> String {
    let mut text = format!(
        "# The motors of {}: effects beyond kS, kV and kA. Written by beeline; change this file with\n\
         # `beeline model add`, `remove` and `fit`, each with --drivetrain, or by hand.\n",
        robot.replace(|letter: char| letter.is_control(), " ")
    );
    for effect in &model.effects {
        // Writing to a String cannot fail.
        let facts = effect.facts;
        let _ = write!(text, "\n[[effect]]  # {}\nid = \"{}\"\n", facts.name, facts.id);
        let _ = writeln!(text, "# {}", facts.equation.replace('\n', " "));
        for parameter in &effect.parameters {
            let (value, half_width) = (parameter.value, parameter.half_width_95);
            let _ = writeln!(
                text,
                "parameters.{} = {{ value = {}, half_width_95 = {}, unit = \"{}\" }}",
                parameter.name,
                number(value),
                number(half_width),
                parameter.unit
            );
        }
    }
    text
}

/// As TOML has it: a number with a point or an exponent, or inf.
fn number(value: f64) -> String {
    format!("{value:?}")
}
