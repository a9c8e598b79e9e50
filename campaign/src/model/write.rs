//! Writes `model.toml`, for people to read: whole or not at all.

use std::fmt::Write;
use std::path::Path;

use robot_model::effect::Effect;
use robot_model::estimation::Errors;

use super::{FitEntry, ModelFile};
use crate::equation_words::{one_line, quoted};
use crate::file::{write_new, write_own};
use crate::{CampaignError, Place};

const UP_TO: &str = "# The runs cannot tell it from other effects. Above their mean speed it acts as at that speed.\n";
const IN_USE: &str = "\
    # From the robot's configuration when these runs were recorded, not fitted to them.\n\
    in_use = true\n";

impl ModelFile {
    /// Writes the model of the robot of this name.
    pub fn write(&self, file: &Path, robot: &str) -> Result<(), CampaignError> {
        write_own(file, self.to_text(robot).as_bytes()).map_err(|error| {
            let problem = format!("cannot write it ({error})");
            CampaignError::new(
                Place::whole(file),
                problem,
                error.hint("check the path and the disk"),
            )
        })
    }

    /// Writes the model if the file does not exist yet; false if it does.
    pub fn write_new(&self, file: &Path, robot: &str) -> Result<bool, CampaignError> {
        write_new(file, self.to_text(robot).as_bytes()).map_err(|error| {
            let problem = format!("cannot write it ({error})");
            CampaignError::new(
                Place::whole(file),
                problem,
                error.hint("check the path and the disk"),
            )
        })
    }

    /// The text of the file.
    pub fn to_text(&self, robot: &str) -> String {
        let robot = one_line(robot);
        let mut text = format!(
            "# The model of {robot}: effects that the nominal robot lacks. Written by beeline; change this file\n\
             # with `beeline model add`, `remove` and `fit`, or by hand.\n"
        );
        // Writing to a String cannot fail.
        for entry in &self.effects {
            let facts = entry.effect.facts();
            let _ = write!(
                text,
                "\n[[effect]]  # {}\nid = {}\n# {}\n",
                one_line(facts.name),
                quoted(facts.id),
                one_line(facts.equation)
            );
            if entry.in_use {
                text.push_str(IN_USE);
            }
            if let Some(up_to_mps) = entry.up_to_mps {
                let _ = writeln!(text, "{UP_TO}up_to_mps = {}", digits(up_to_mps));
            }
            for parameter in &entry.parameters {
                let _ = writeln!(
                    text,
                    "parameters.{} = {{ value = {}, sigma = {}, low95 = {}, high95 = {}, unit = {} }}",
                    parameter.name,
                    digits(parameter.value),
                    digits(parameter.sigma),
                    digits(parameter.low95),
                    digits(parameter.high95),
                    quoted(&parameter.unit)
                );
            }
        }
        for custom in &self.customs {
            let declared = custom.custom();
            let _ = write!(
                text,
                "\n[[custom]]  # an effect of your own: {}\nid = {}\ntarget = {}\nper = {}\nexpression = {}\n",
                one_line(&declared.equation()),
                quoted(&declared.id),
                quoted(declared.target.name()),
                quoted(declared.per.name()),
                quoted(&declared.expression)
            );
            for parameter in custom.facts().parameters {
                let _ = writeln!(text, "unit.{} = {}", parameter.name, quoted(&parameter.unit));
            }
            for (name, [low, high]) in &declared.ranges {
                let _ = writeln!(text, "range.{name} = [{low:?}, {high:?}]");
            }
        }
        if let Some(fit) = &self.fit {
            errors(&mut text, fit);
            noise(&mut text, fit);
        }
        text
    }
}

/// Six digits: more than the sigma of any parameter makes significant.
fn digits(value: f64) -> String {
    format!("{:?}", format!("{value:.5e}").parse().unwrap_or(value))
}

fn errors(text: &mut String, fit: &FitEntry) {
    let line = |errors: &Errors| {
        format!(
            "{{ position_rms_m = {}, heading_rms_rad = {}, chi = {} }}",
            digits(errors.position_rms_m),
            digits(errors.heading_rms_rad),
            digits(errors.chi)
        )
    };
    let _ = write!(
        text,
        "\n[error]  # predicted against measured; cross_validated: each run predicted by a fit to the others\n\
         runs = {}\nnominal = {}\nnominal_cross_validated = {}\ntrain = {}\ncross_validated = {}\n",
        fit.runs,
        line(&fit.nominal.fitted),
        line(&fit.nominal.cross_validated),
        line(&fit.errors.fitted),
        line(&fit.errors.cross_validated)
    );
}

fn noise(text: &mut String, fit: &FitEntry) {
    let noise = &fit.noise;
    let _ = write!(
        text,
        "\n[noise]  # one sigma; walk: random walk of dead reckoning over one metre (gyro: one second)\n\
         position_sigma_m = {}\nheading_sigma_rad = {}\ntravel_walk = {}\nheading_walk = {}\n\
         position_wobble_m = {}\nheading_wobble_rad = {}\nwobble_s = {}\ngyro_walk = {}\n\
         heading_offset_rad = {}\nclock_offset_s = {}\n",
        digits(noise.position_sigma_m),
        digits(noise.heading_sigma_rad),
        digits(noise.travel_walk),
        digits(noise.heading_walk),
        digits(noise.position_wobble_m),
        digits(noise.heading_wobble_rad),
        digits(noise.wobble_s),
        digits(noise.gyro_walk),
        digits(noise.heading_offset_rad),
        digits(noise.clock_offset_s)
    );
}
