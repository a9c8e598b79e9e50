//! The shipped scenarios (`sim-target/scenarios/`): is the cause of each named, and is nothing saved that makes the
//! next straight worse?
//!
//! | module | what it is |
//! | --- | --- |
//! | [`cause`] | what is truly wrong in each scenario, and what `explain` says of its usual campaign |
//! | [`saving`] | every procedure that saves a number, and the next straights with that number and without |

pub mod cause;
pub mod saving;

use std::path::{Path, PathBuf};

use sim_target::Scenario;
use sim_target::plant::PlantParameters;

/// The folder of the shipped scenarios.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../sim-target/scenarios")
}

/// Not shipped: an otherwise perfect robot with play in both gears.
pub const PLAY_ALONE: &str = "play_alone";

/// A shipped scenario with another seed, or [`PLAY_ALONE`].
///
/// # Panics
/// If it is not there or cannot be read.
pub fn shipped(name: &str, seed: u64) -> Scenario {
    if name == PLAY_ALONE {
        let mut scenario = Scenario { name: "play alone".into(), seed, ..Scenario::default() };
        scenario.plant = PlantParameters::default();
        scenario.plant.gear.left.backlash_rad = 0.03;
        scenario.plant.gear.right.backlash_rad = 0.03;
        return scenario;
    }
    let file = folder().join(format!("{name}.toml"));
    let scenario = Scenario::load(&file).unwrap_or_else(|error| panic!("{error}"));
    Scenario { seed, ..scenario }
}

/// The names of all shipped scenarios, sorted, and [`PLAY_ALONE`].
///
/// # Panics
/// If the folder cannot be listed.
pub fn names() -> Vec<String> {
    let entries = std::fs::read_dir(folder()).expect("the scenarios' folder");
    let files = entries.map(|entry| entry.expect("an entry").path());
    let stem = |file: PathBuf| Some(file.file_stem()?.to_str()?.to_string());
    let mut names: Vec<String> = files.filter_map(stem).collect();
    names.sort();
    names.push(PLAY_ALONE.to_string());
    names
}
