//! Writes `model.toml`, for people to read: whole or not at all.

use std::fmt::Write;
use std::path::Path;

use robot_model::effect::Effect;
use robot_model::estimation::Errors;

use super::{FitEntry, ModelFile};
use crate::file::{write_new, write_whole};
use crate::{CampaignError, Place};

const IN_USE: &str = "\
    # From the robot's configuration when these runs were recorded, not fitted to them.\n\
    in_use = true\n";

impl ModelFile {
    /// Writes the model of the robot of this name.
    pub fn write(&self, file: &Path, robot: &str) -> Result<(), CampaignError> {
        write_whole(file, self.to_text(robot).as_bytes()).map_err(|error| {
            let problem = format!("cannot write it ({error})");
            CampaignError::new(Place::whole(file), problem, "check the path and the disk")
        })
    }

    /// Writes it where there is none yet.
    pub fn write_new(&self, file: &Path, robot: &str) -> Result<(), CampaignError> {
        write_new(file, self.to_text(robot).as_bytes()).map(|_| ()).map_err(|error| {
            let problem = format!("cannot write it ({error})");
            CampaignError::new(Place::whole(file), problem, "check the path and the disk")
        })
    }

    /// Its text.
    pub fn to_text(&self, robot: &str) -> String {
        // A comment is one line, whatever the name.
        let robot: String = robot.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
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
                facts.name,
                quoted(facts.id),
                facts.equation
            );
            if entry.in_use {
                text.push_str(IN_USE);
            }
            for it in &entry.parameters {
                let _ = writeln!(
                    text,
                    "parameters.{} = {{ value = {}, sigma = {}, low95 = {}, high95 = {}, unit = {} }}",
                    it.name,
                    digits(it.value),
                    digits(it.sigma),
                    digits(it.low95),
                    digits(it.high95),
                    quoted(&it.unit)
                );
            }
        }
        for custom in &self.customs {
            let it = custom.custom();
            let _ = write!(
                text,
                "\n[[custom]]  # an effect of your own: {}\nid = {}\ntarget = {}\nper = {}\nexpression = {}\n",
                it.equation().replace(|c: char| c.is_control(), " "),
                quoted(&it.id),
                quoted(it.target.name()),
                quoted(it.per.name()),
                quoted(&it.expression)
            );
            for parameter in custom.facts().parameters {
                let _ = writeln!(text, "unit.{} = {}", parameter.name, quoted(&parameter.unit));
            }
            for (name, [low, high]) in &it.ranges {
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

/// A TOML string.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// Six digits: more than any sigma leaves of meaning.
fn digits(value: f64) -> String {
    format!("{:?}", format!("{value:.5e}").parse().unwrap_or(value))
}

fn errors(text: &mut String, fit: &FitEntry) {
    let line = |it: &Errors| {
        format!(
            "{{ position_rms_m = {}, heading_rms_rad = {}, chi = {} }}",
            digits(it.position_rms_m),
            digits(it.heading_rms_rad),
            digits(it.chi)
        )
    };
    let _ = write!(
        text,
        "\n[error]  # predicted against measured; heldout: cross-validated, each run predicted by a fit to the others\n\
         runs = {}\nnominal = {}\nnominal_heldout = {}\ntrain = {}\nheldout = {}\n",
        fit.runs,
        line(&fit.nominal.train),
        line(&fit.nominal.cross_validated),
        line(&fit.errors.train),
        line(&fit.errors.cross_validated)
    );
}

fn noise(text: &mut String, fit: &FitEntry) {
    let it = &fit.noise;
    let _ = write!(
        text,
        "\n[noise]  # one sigma; walk: random walk of dead reckoning over one metre (gyro: one second)\n\
         position_sigma_m = {}\nheading_sigma_rad = {}\ntravel_walk = {}\nheading_walk = {}\n\
         position_wobble_m = {}\nheading_wobble_rad = {}\nwobble_s = {}\ngyro_walk = {}\n\
         heading_offset_rad = {}\nclock_offset_s = {}\n",
        digits(it.position_sigma_m),
        digits(it.heading_sigma_rad),
        digits(it.travel_walk),
        digits(it.heading_walk),
        digits(it.position_wobble_m),
        digits(it.heading_wobble_rad),
        digits(it.wobble_s),
        digits(it.gyro_walk),
        digits(it.heading_offset_rad),
        digits(it.clock_offset_s)
    );
}
