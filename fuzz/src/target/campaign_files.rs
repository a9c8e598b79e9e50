//! The files of a campaign folder.

use std::fmt::Write as _;
use std::path::Path;

use campaign::model::ModelFile;
use campaign::motor_model::MotorModelFile;
use campaign::plan::CampaignPlan;
use campaign::{Column, RobotFile, parse_run};
use robot_model::drivetrain::{MotorCustom, MotorEffect};

use crate::bytes::text;

/// What errors call the file.
const FILE: &str = "file";

/// `robot.toml`.
pub fn robot_toml(input: &[u8]) {
    let Some(text) = text(input) else { return };
    let file = Path::new(FILE);
    let robot = match RobotFile::parse(file, text) {
        Ok(robot) => robot,
        Err(error) => return said(&error.to_string()),
    };
    let numbers =
        [robot.wheel_radius_m, robot.track_width_m, robot.counts_per_rev, robot.gear_reduction];
    assert!(numbers.iter().all(|number| *number > 0.0 && number.is_finite()), "{numbers:?}");
    let sigmas = [robot.position_sigma_m, robot.heading_sigma_rad, robot.supply_v];
    assert!(sigmas.iter().flatten().all(|number| *number > 0.0 && number.is_finite()));
    for run in &robot.runs {
        assert!(run.payload_kg.is_none_or(|load| load >= 0.0 && load.is_finite()));
        assert!(run.started_s.is_none_or(f64::is_finite));
    }
    let written = toml::to_string(&robot).expect("what was read can be written");
    let again = RobotFile::parse(file, &written).unwrap_or_else(|e| panic!("{e}\n{written}"));
    assert_eq!(robot, again);
    assert_eq!(robot.difference(&again), None);
}

/// A run.
pub fn run_csv(input: &[u8]) {
    let file = Path::new(FILE);
    let rows = match parse_run(file, input) {
        Ok((rows, warnings)) => {
            warnings.iter().for_each(|warning| said(&warning.to_string()));
            rows
        }
        Err(error) => return said(&error.to_string()),
    };
    assert!(rows.len() >= 2);
    assert!(rows.windows(2).all(|pair| pair[0].t_s < pair[1].t_s), "times increase");
    let mut written = Column::ALL.map(Column::name).join(",");
    for row in &rows {
        written.push('\n');
        for (index, column) in Column::ALL.into_iter().enumerate() {
            let value = row.get(column);
            assert!(value.is_none_or(|value| column.range().contains(value)), "{column:?} {row:?}");
            let comma = if index == 0 { "" } else { "," };
            let _ = match value {
                Some(value) => write!(written, "{comma}{value:?}"),
                None => write!(written, "{comma}"),
            };
        }
    }
    let (again, warnings) =
        parse_run(file, written.as_bytes()).unwrap_or_else(|error| panic!("{error}\n{written}"));
    assert!(warnings.is_empty());
    assert_eq!(rows, again);
}

/// `model.toml`.
pub fn model_toml(input: &[u8]) {
    let Some(text) = text(input) else { return };
    let file = Path::new(FILE);
    let model = match ModelFile::parse(file, text) {
        Ok(model) => model,
        Err(error) => return said(&error.to_string()),
    };
    for found in model.effects.iter().flat_map(|entry| &entry.parameters) {
        let numbers = [found.value, found.sigma, found.low95, found.high95];
        assert!(numbers.iter().all(|number| number.is_finite()), "{found:?}");
        assert!(found.sigma >= 0.0 && found.low95 <= found.high95, "{found:?}");
    }
    // Six digits are kept, so what is written once more is the same to the byte.
    let written = model.to_text("robot");
    let again = ModelFile::parse(file, &written).unwrap_or_else(|e| panic!("{e}\n{written}"));
    assert_eq!(written, again.to_text("robot"));
}

/// `motors.toml`.
pub fn motors_toml(input: &[u8]) {
    let Some(text) = text(input) else { return };
    let model = match MotorModelFile::parse(Path::new(FILE), text) {
        Ok(model) => model,
        Err(error) => return said(&error.to_string()),
    };
    for own in &model.customs {
        for parameter in own.facts().parameters {
            let ends = [parameter.low, parameter.high, parameter.usual];
            assert!(ends.iter().all(|end| end.is_finite()), "{parameter:?}");
            assert!(parameter.low < parameter.high && parameter.usual > 0.0, "{parameter:?}");
        }
        let again = MotorCustom::from_equation(&own.custom().equation());
        let again = again.expect("an equation is read again");
        assert_eq!(again.expression, own.custom().expression);
    }
}

/// `plan.toml`.
pub fn plan_toml(input: &[u8]) {
    let Some(text) = text(input) else { return };
    let file = Path::new(FILE);
    let plan = match CampaignPlan::parse(file, text) {
        Ok(plan) => plan,
        Err(error) => return said(&error.to_string()),
    };
    // The narrowest robot has the shortest spins.
    let duration_s = plan.duration_s(0.02);
    assert!(duration_s.is_finite() && duration_s >= 0.0, "{duration_s}");
    let floor_m = plan.floor(0.3).size_m();
    assert!(floor_m.iter().all(|side_m| side_m.is_finite()), "{floor_m:?}");
    let written = plan.to_toml();
    let again = CampaignPlan::parse(file, &written).unwrap_or_else(|e| panic!("{e}\n{written}"));
    assert_eq!(written, again.to_toml());
    assert!(plan.drives_the_same_as(&again));
}

/// An error or a warning says something.
fn said(message: &str) {
    assert!(!message.trim().is_empty());
}
