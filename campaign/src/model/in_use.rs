//! Which effects a robot compensates already, as the first model of a campaign recorded on it.
//!
//! ```text
//! rho = 2 (W_T - 1) / (W_T + 1),   s = R_L (1 + W_T) / (2 R) - 1,   delta = b' / b - 1     (1)
//! ```
//!
//! W_T, R_L, b' and the heading pull come from the robot's configuration, R and b from the
//! campaign's `robot.toml`; (1) is the inverse of what `beeline apply` writes. Counts are raw, so
//! an effect that the robot compensates still shows in them: without these entries `explain` would
//! report it as missing. The values are exact, as they are configured and not measured.

use std::path::Path;

use robot_model::effect::{CATALOGUE, FirmwareTerm, KnownEffect};
use robot_model::explain::ParameterFound;
use shared_proto::Config;

use super::{EffectEntry, ModelFile};
use crate::robot_toml::mean_radius_m;
use crate::{CampaignError, Place, RobotFile};

/// Smaller values are rounding: a file has fewer digits than a configuration.
const NOTHING: f64 = 1e-9;

/// The effects that a robot with this configuration compensates, relative to this nominal robot.
pub fn effects(nominal: &RobotFile, config: &Config) -> Vec<EffectEntry> {
    let in_use = &config.geometry;
    let weight = in_use.wheel_weight;
    // (1)
    let value = |term: FirmwareTerm| match term {
        FirmwareTerm::WheelWeight => 2.0 * (weight - 1.0) / (weight + 1.0),
        FirmwareTerm::MeanRadius => mean_radius_m(in_use) / nominal.wheel_radius_m - 1.0,
        FirmwareTerm::TrackWidth => in_use.track_width_m / nominal.track_width_m - 1.0,
        FirmwareTerm::HeadingPull => in_use.heading_pull_rad_per_m,
    };
    let entry = |effect: KnownEffect| {
        let facts = effect.facts();
        let value = value(facts.compensated_by?);
        let of = facts.parameters.first().filter(|_| value.abs() > NOTHING)?;
        let (name, unit) = (of.name.to_string(), of.unit.to_string());
        let found = ParameterFound { name, unit, value, sigma: 0.0, low95: value, high95: value };
        let entry = EffectEntry::unfitted(effect.clone());
        Some(EffectEntry { parameters: vec![found], in_use: true, ..entry })
    };
    CATALOGUE.into_iter().map(KnownEffect::BuiltIn).filter_map(entry).collect()
}

/// The result of [`record`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CompensationRecord {
    /// Nothing to report: nothing is compensated, or the model agrees.
    Nothing,
    /// A model with the effects of these ids was written for a new campaign.
    Written(Vec<String>),
    /// The robot compensates another value of this effect now than when the campaign began.
    Changed(String),
}

/// Writes what the robot compensates into the model of a campaign that has no run yet; an existing
/// model stays as it is.
///
/// A campaign without runs is refused if its model is of another configuration. One with runs goes
/// on: as counts are raw, runs from before and after a change of the configuration belong together.
pub fn record(
    folder: &Path,
    nominal: &RobotFile,
    config: &Config,
    has_runs: bool,
) -> Result<CompensationRecord, CampaignError> {
    let place = ModelFile::place(folder);
    let effects = effects(nominal, config);
    if place.exists() {
        let there = ModelFile::read(&place)?;
        return match changed(&there, &effects) {
            None => Ok(CompensationRecord::Nothing),
            Some(id) if has_runs => Ok(CompensationRecord::Changed(id)),
            Some(id) => {
                let problem =
                    format!("the robot now compensates a different {id} from the one in this file");
                let hint =
                    "remove this file, as the campaign has no runs yet, or choose another folder";
                Err(CampaignError::new(Place::whole(&place), problem, hint))
            }
        };
    }
    if has_runs || effects.is_empty() {
        return Ok(CompensationRecord::Nothing);
    }
    let ids = effects.iter().map(|entry| entry.id().to_owned()).collect();
    let model = ModelFile { effects, ..ModelFile::default() };
    model.write_new(&place, &nominal.name)?;
    Ok(CompensationRecord::Written(ids))
}

/// The first effect in use whose value differs between now and a model. Effects that were fitted
/// since do not count.
fn changed(model: &ModelFile, now: &[EffectEntry]) -> Option<String> {
    // The model keeps six digits.
    let same = |a: f64, b: f64| (a - b).abs() <= 1e-5 * a.abs() + NOTHING;
    let value =
        |entry: &EffectEntry| entry.parameters.first().map_or(0.0, |parameter| parameter.value);
    let now_of = |id: &str| now.iter().find(|entry| entry.id() == id).map_or(0.0, value);
    let differs = |entry: &&&EffectEntry| !same(value(entry), now_of(entry.id()));
    model.in_use().iter().find(differs).map(|entry| entry.id().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn calibrated() -> Config {
        let mut config = Config::default();
        config.geometry.wheel_weight = 0.99;
        config.geometry.wheel_radius_m = 0.0361;
        config
    }

    fn values(nominal: &RobotFile, config: &Config) -> Vec<(String, f64)> {
        let entries = effects(nominal, config);
        entries.iter().map(|entry| (entry.id().to_owned(), entry.parameters[0].value)).collect()
    }

    #[test]
    fn a_robot_as_it_left_the_factory_compensates_nothing() {
        let config = Config::default();
        assert!(values(&RobotFile::of(&config), &config).is_empty());
    }

    #[test]
    fn seen_from_its_own_mean_radius_a_robot_compensates_the_ratio_alone() {
        let config = calibrated();
        let [(ref id, rho)] = values(&RobotFile::of(&config), &config)[..] else { panic!() };
        assert_eq!(id, "wheel_radius_ratio");
        // Back again by apply's (1).
        assert!(((1.0 + rho / 2.0) / (1.0 - rho / 2.0) - 0.99).abs() < 1e-15);
    }

    #[test]
    fn seen_from_another_nominal_robot_scale_and_track_are_in_use_too() {
        let nominal = RobotFile::of(&Config::default());
        let mut config = calibrated();
        config.geometry.track_width_m *= 1.02;
        config.geometry.heading_pull_rad_per_m = -0.004;
        let found = values(&nominal, &config);
        let ids: Vec<&str> = found.iter().map(|(id, _)| id.as_str()).collect();
        assert_eq!(
            ids,
            ["wheel_radius_ratio", "wheel_radius_scale", "track_width", "heading_pull"]
        );
        assert_eq!(found[3].1, -0.004);
        let mean_m = nominal.wheel_radius_m * (1.0 + found[1].1);
        let left_m = mean_m * (1.0 - found[0].1 / 2.0);
        assert!((left_m - 0.0361).abs() < 1e-15, "{left_m}");
        assert!((found[2].1 - 0.02).abs() < 1e-12);
    }

    #[test]
    fn a_model_that_is_there_stays_and_another_configuration_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let (folder, place) = (folder.path(), ModelFile::place(folder.path()));
        let config = calibrated();
        let nominal = RobotFile::of(&config);
        let record = |config: &Config, has_runs| super::record(folder, &nominal, config, has_runs);
        // The runs were recorded before: their owner must say what the robot compensated then.
        assert_eq!(record(&config, true).unwrap(), CompensationRecord::Nothing);
        assert!(!place.exists());
        assert_eq!(
            record(&config, false).unwrap(),
            CompensationRecord::Written(vec!["wheel_radius_ratio".to_owned()])
        );
        let text = std::fs::read_to_string(&place).unwrap();
        assert!(text.contains("robot's configuration") && text.contains("in_use = true"), "{text}");
        assert_eq!(record(&config, true).unwrap(), CompensationRecord::Nothing);
        let mut other = calibrated();
        other.geometry.wheel_weight = 1.001;
        assert_eq!(
            record(&other, true).unwrap(),
            CompensationRecord::Changed("wheel_radius_ratio".to_owned())
        );
        let error = record(&other, false).unwrap_err().to_string();
        assert!(error.contains("a different wheel_radius_ratio"), "{error}");
        assert_eq!(std::fs::read_to_string(&place).unwrap(), text);
        // Once fitted, the entry has the fitted value, not the one in use.
        std::fs::write(&place, text.replace("in_use = true\n", "")).unwrap();
        assert_eq!(record(&other, false).unwrap(), CompensationRecord::Nothing);
    }
}
