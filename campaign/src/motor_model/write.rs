//! Writes `motors.toml`, for people to read: whole or not at all.

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use robot_model::drivetrain::{ChosenModel, CustomMotorEffect, MotorEffect};

use super::MotorModelFile;
use crate::equation_words::{one_line, quoted};
use crate::file::write_own;
use crate::{CampaignError, Place};

impl MotorModelFile {
    /// Writes a model that was fitted, and the user's own effects.
    pub fn write(
        file: &Path,
        robot: &str,
        customs: &[Arc<CustomMotorEffect>],
        model: &ChosenModel,
    ) -> Result<(), CampaignError> {
        write_own(file, text(robot, customs, model).as_bytes()).map_err(|error| {
            let problem = format!("cannot write it ({error})");
            let hint = error.hint("check the path and the disk");
            CampaignError::new(Place::whole(file), problem, hint)
        })
    }
}

pub(super) fn text(robot: &str, customs: &[Arc<CustomMotorEffect>], model: &ChosenModel) -> String {
    let mut text = format!(
        "# The motors of {}: effects beyond kS, kV and kA. Written by beeline; change this file with\n\
         # `beeline model add`, `remove` and `fit`, each with --drivetrain, or by hand. The values are those of the last\n\
         # fit: each command fits them again.\n",
        one_line(robot)
    );
    for effect in &model.effects {
        // Writing to a String cannot fail.
        let facts = effect.effect.facts();
        let (name, id) = (one_line(facts.name), quoted(facts.id));
        let _ = write!(text, "\n[[effect]]  # {name}\nid = {id}\n");
        let _ = writeln!(text, "# {}", one_line(facts.equation));
        for parameter in &effect.parameters {
            // Of what these experiments do not tell there is none.
            let half_width = match parameter.half_width_95 {
                width if width > 0.0 && width.is_finite() => {
                    format!("half_width_95 = {}, ", number(width))
                }
                _ => String::new(),
            };
            let _ = writeln!(
                text,
                "parameters.{} = {{ value = {}, {half_width}unit = {} }}",
                parameter.name,
                number(parameter.value),
                quoted(&parameter.unit)
            );
        }
    }
    for custom in customs {
        let declared = custom.custom();
        let _ = write!(
            text,
            "\n[[custom]]  # an effect of your own\nid = {}\nequation = {}\n",
            quoted(&declared.id),
            quoted(&declared.equation())
        );
        for parameter in custom.facts().parameters {
            let _ = writeln!(text, "unit.{} = {}", parameter.name, quoted(&parameter.unit));
        }
        for (name, [low, high]) in &declared.ranges {
            let _ = writeln!(text, "range.{name} = [{low:?}, {high:?}]");
        }
    }
    text
}

/// As TOML has it: a number with a point or an exponent.
fn number(value: f64) -> String {
    format!("{value:?}")
}
