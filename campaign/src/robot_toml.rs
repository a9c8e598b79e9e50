//! `robot.toml`: the nominal robot, and facts about single runs.

use std::collections::HashSet;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};
use shared_proto::{Config, GeometryConfig};

use crate::bounded_read;
use crate::error::{CampaignError, Place};
use crate::range;
use crate::simulated::Simulated;
use crate::toml_text::parse_toml;

/// The robot of a campaign, as in `robot.toml`. That of `default` has zeros for a geometry, which no reader accepts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotFile {
    /// What its owner calls it.
    pub name: String,
    /// Nominal radius of both wheels \[m\].
    pub wheel_radius_m: f64,
    /// Nominal distance between the wheels \[m\].
    pub track_width_m: f64,
    /// Encoder counts per encoder revolution as logged; may be fractional.
    pub counts_per_rev: f64,
    /// Encoder revolutions per wheel revolution, the paper's 1/g.
    #[serde(default = "one")]
    pub gear_reduction: f64,
    /// Noise of x_m and y_m \[m\]; estimated from the data when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_sigma_m: Option<f64>,
    /// Noise of heading_rad \[rad\]; estimated from the data when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heading_sigma_rad: Option<f64>,
    /// Nominal supply \[V\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub supply_v: Option<f64>,
    /// The board's unique number, in hexadecimal: two robots may have the same nominal values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uid: Option<String>,
    /// Which simulated robot it is, if it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulated: Option<Simulated>,
    /// Facts about single runs.
    #[serde(rename = "run", default, skip_serializing_if = "Vec::is_empty")]
    pub runs: Vec<RunFacts>,
}

/// Facts about one run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunFacts {
    /// File name without `.csv`.
    pub name: String,
    /// When it began, on one clock for the whole campaign \[s\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub started_s: Option<f64>,
    /// Payload on board \[kg\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub payload_kg: Option<f64>,
    /// Held out: nothing is fitted to it; it only tests what a model predicts.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub held_out: bool,
    /// Its file is about to appear: without the file there is no such run.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub pending: bool,
}

impl RunFacts {
    /// Whether it says anything but the name.
    pub fn has_any(&self) -> bool {
        let Self { name: _, started_s, payload_kg, held_out, pending } = self;
        started_s.is_some() || payload_kg.is_some() || *held_out || *pending
    }
}

/// No wheel is off by more, as a share, and no calibration changes a robot by more.
const GEOMETRY_FAR: f64 = 0.1;
/// A file may have fewer digits than the robot.
const DIGITS: f64 = 1e-9;

fn one() -> f64 {
    1.0
}

/// The mean radius of both wheels \[m\].
pub fn mean_radius_m(geometry: &GeometryConfig) -> f64 {
    geometry.wheel_radius_m * (1.0 + geometry.wheel_weight) / 2.0
}

impl RobotFile {
    /// The nominal robot of this configuration.
    ///
    /// The file has one encoder for both wheels, here the left one. Its radius is the mean of both
    /// wheels as configured, so that W_T becomes wheel_radius_ratio alone: see
    /// [`crate::model::in_use`].
    pub fn of(config: &Config) -> Self {
        let encoder = config.encoder.left;
        let name = match config.name.as_str() {
            "" => "unnamed robot",
            name => name,
        };
        Self {
            name: name.into(),
            wheel_radius_m: mean_radius_m(&config.geometry),
            track_width_m: config.geometry.track_width_m,
            counts_per_rev: encoder.counts_per_rev,
            gear_reduction: encoder.gear_reduction,
            ..Self::default()
        }
    }

    /// Reads and checks a `robot.toml`.
    pub fn read(file: &Path) -> Result<Self, CampaignError> {
        let text = bounded_read::read_keys(file).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => CampaignError::new(
                Place::whole(file),
                "there is no such file",
                "a campaign is a folder with a robot.toml and a folder `runs`",
            ),
            io::ErrorKind::NotADirectory => CampaignError::new(
                Place::whole(file.parent().unwrap_or(file)),
                "this is a file, not a campaign",
                "a campaign is a folder with a robot.toml and a folder `runs`",
            ),
            _ => CampaignError::io(file, "read it", error),
        })?;
        Self::parse(file, &text)
    }

    /// Reads and checks the text of a `robot.toml`; errors call it `file`.
    pub fn parse(file: &Path, text: &str) -> Result<Self, CampaignError> {
        let robot: Self = parse_toml(file, text, hint_for)?;
        robot.check(file, text)?;
        Ok(robot)
    }

    /// Refuses a value that no robot can have, with its name and place.
    pub(super) fn check(&self, file: &Path, text: &str) -> Result<(), CampaignError> {
        let keys = [
            ("wheel_radius_m", Some(self.wheel_radius_m)),
            ("track_width_m", Some(self.track_width_m)),
            ("counts_per_rev", Some(self.counts_per_rev)),
            ("gear_reduction", Some(self.gear_reduction)),
            ("position_sigma_m", self.position_sigma_m),
            ("heading_sigma_rad", self.heading_sigma_rad),
            ("supply_v", self.supply_v),
        ];
        for (name, value) in keys {
            check_range(name, value, |name| place_of(file, text, 0, name))?;
        }
        let mut names = HashSet::new();
        for (index, run) in self.runs.iter().enumerate() {
            if !names.insert(run.name.as_str()) {
                let place = place_of(file, text, start_of_run(text, index), "name");
                let problem = format!("there are two [[run]] named `{}`", run.name);
                return Err(CampaignError::new(place, problem, "merge them into one"));
            }
            let place = |name: &str| place_of(file, text, start_of_run(text, index), name);
            for (name, value) in [("started_s", run.started_s), ("payload_kg", run.payload_kg)] {
                check_range(name, value, place)?;
            }
        }
        Ok(())
    }

    /// The first value in which another robot differs: its name and both values.
    ///
    /// The name does not count, as it can be changed, and a uid counts only if both have one.
    /// Wheels and track are those of the robot as calibrated: `apply` changes them, and the robot
    /// is still the same.
    pub fn difference(&self, other: &Self) -> Option<(&'static str, String, String)> {
        if let (Some(here), Some(there)) = (&self.uid, &other.uid)
            && !here.eq_ignore_ascii_case(there)
        {
            return Some(("uid", here.clone(), there.clone()));
        }
        [
            ("counts_per_rev", self.counts_per_rev, other.counts_per_rev, DIGITS),
            ("gear_reduction", self.gear_reduction, other.gear_reduction, DIGITS),
            ("wheel_radius_m", self.wheel_radius_m, other.wheel_radius_m, GEOMETRY_FAR),
            ("track_width_m", self.track_width_m, other.track_width_m, GEOMETRY_FAR),
        ]
        .into_iter()
        .find(|(_, a, b, far)| (a - b).abs() > far * a.abs())
        .map(|(name, a, b, _)| (name, a.to_string(), b.to_string()))
    }
}

/// Refuses a number that its key cannot have.
fn check_range(
    key: &str,
    value: Option<f64>,
    place: impl FnOnce(&str) -> Place,
) -> Result<(), CampaignError> {
    let (Some(value), Some(range)) = (value, range::of_key(key)) else { return Ok(()) };
    if range.contains(value) {
        return Ok(());
    }
    let problem = format!("{key} = {} is invalid", range::short(value));
    Err(CampaignError::new(place(key), problem, format!("it must be {range}")))
}

/// What to try about a problem that the TOML parser reports.
fn hint_for(problem: &str) -> &'static str {
    if problem.starts_with("missing field `name`") {
        "the robot needs one, and so does each [[run]]: name = \"my-robot\""
    } else if problem.starts_with("missing field") {
        "name, wheel_radius_m, track_width_m and counts_per_rev are required"
    } else if problem.starts_with("unknown field") {
        "check its spelling; keys of the robot belong above the first [[run]], keys of a run below it"
    } else if problem.contains("expected f64") {
        "a number, without quotes and unit, with a decimal point: wheel_radius_m = 0.036"
    } else if problem.contains("expected a boolean") {
        "true or false, without quotes"
    } else if problem.contains("expected a string") {
        "a text in quotes"
    } else {
        "each line is `key = value`, a text in quotes, a number without"
    }
}

/// The byte at which the section of a run, counted from 0, begins; 0 if the runs are not `[[run]]`
/// sections.
pub(crate) fn start_of_run(text: &str, index: usize) -> usize {
    let mut start = 0;
    let headers = text.split_inclusive('\n').filter_map(|line| {
        let here = start;
        start += line.len();
        let name = line.trim_start().strip_prefix("[[")?.split("]]").next()?;
        (name.trim() == "run").then_some(here)
    });
    headers.collect::<Vec<_>>().get(index).copied().unwrap_or(0)
}

/// The place of a key of the robot.
pub(super) fn place_of_key(file: &Path, key: &str) -> Place {
    place_of(file, &bounded_read::read_keys(file).unwrap_or_default(), 0, key)
}

/// The first place of a key, from a byte on.
fn place_of(file: &Path, text: &str, from: usize, key: &str) -> Place {
    let mut start = from;
    for line in text[from..].split_inclusive('\n') {
        let indent = line.len() - line.trim_start().len();
        let after_key = line.trim_start().strip_prefix(key);
        if after_key.is_some_and(|rest| rest.trim_start().starts_with('=')) {
            return Place::of_byte(file, text, start + indent);
        }
        start += line.len();
    }
    Place::whole(file)
}

/// The place of the name of a run.
pub(super) fn place_of_run(file: &Path, name: &str) -> Place {
    let text = bounded_read::read_keys(file).unwrap_or_default();
    match text.find(&format!("\"{name}\"")) {
        Some(byte) => Place::of_byte(file, &text, byte),
        None => Place::whole(file),
    }
}
