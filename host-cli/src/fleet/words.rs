//! What a fleet shows, in sentences, the most important first.

use findings::quantity::{value_in_unit, value_with_sigma};
use robot_model::effect::Group;
use robot_model::fleet::{RobotJudged, Trend, is_wear};

use super::{Fleet, FleetParameter, Kind};

/// Rates are told for so many days.
pub(super) const MONTH_DAYS: f64 = 30.0;

/// One finding.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// `wears`, `drifts`, `unlike` or `common`.
    pub what: &'static str,
    /// The kind of robot.
    pub kind: String,
    /// The robot, if it is about one.
    pub robot: Option<String>,
    /// The effect's id.
    pub effect: String,
    /// In a sentence.
    pub words: String,
}

/// What is said where nothing was found.
pub fn nothing_found(fleet: &Fleet) -> &'static str {
    match fleet.kinds.iter().any(Kind::is_comparable) {
        true => "No robot stands out",
        false => "Nothing to compare: one robot of each kind, on one day",
    }
}

/// All that is found.
pub fn findings_of(fleet: &Fleet) -> Vec<Finding> {
    let mut all: Vec<Finding> = fleet.kinds.iter().flat_map(of_kind).collect();
    let rank =
        |what: &str| ["wears", "drifts", "unlike", "common"].iter().position(|one| *one == what);
    all.sort_by_key(|finding| rank(finding.what));
    all
}

fn of_kind(kind: &Kind) -> Vec<Finding> {
    let mut all = Vec::new();
    for parameter in &kind.parameters {
        let facts = parameter.effect.facts();
        let mut add = |what, robot: Option<&RobotJudged>, words| {
            all.push(Finding {
                what,
                kind: kind.name.clone(),
                robot: robot.map(|robot| kind.robots[robot.robot].clone()),
                effect: facts.id.to_owned(),
                words,
            });
        };
        for robot in &parameter.judgement.robots {
            let name = &kind.robots[robot.robot];
            if let Some(trend) = robot.trend.filter(|trend| trend.is_there) {
                let (what, words) = changes(name, parameter, robot, &trend);
                add(what, Some(robot), words);
            }
            // What changes with time is told already.
            if robot.is_unlike && !robot.trend.is_some_and(|trend| trend.is_there) {
                add("unlike", Some(robot), unlike(name, parameter, robot));
            }
        }
        if parameter.judgement.is_common {
            add("common", None, common(kind, parameter));
        }
    }
    all
}

fn changes(
    name: &str,
    parameter: &FleetParameter,
    robot: &RobotJudged,
    trend: &Trend,
) -> (&'static str, String) {
    let facts = parameter.effect.facts();
    let wears = is_wear(parameter.effect, trend.per_day);
    let per_day = if wears { -trend.per_day } else { trend.per_day };
    let rate = value_with_sigma(MONTH_DAYS * per_day, MONTH_DAYS * trend.sigma, &parameter.unit);
    let (what, begins) = if wears {
        ("wears", format!("{name} wears: its wheels shrink"))
    } else {
        ("drifts", format!("{name} drifts: {}", facts.name))
    };
    let floor = if facts.group == Group::Floor {
        "; this belongs to the floor, not to the robot"
    } else {
        ""
    };
    (
        what,
        format!("{begins} by {rate} in {MONTH_DAYS} days ({} campaigns){floor}.", robot.campaigns),
    )
}

fn unlike(name: &str, parameter: &FleetParameter, robot: &RobotJudged) -> String {
    let value = value_with_sigma(robot.mean, robot.sigma, &parameter.unit);
    let (mean, spread) = (parameter.judgement.mean, parameter.judgement.spread);
    format!(
        "{name} is unlike the others: {} of {value}, where the mean of its kind has {}.",
        parameter.effect.facts().name,
        value_with_sigma(mean, spread.max(parameter.judgement.mean_sigma), &parameter.unit)
    )
}

fn common(kind: &Kind, parameter: &FleetParameter) -> String {
    let judgement = &parameter.judgement;
    let spread = match judgement.spread {
        spread if spread > 0.0 => {
            format!("robots differ by {}", value_in_unit(spread, spread / 10.0, &parameter.unit))
        }
        _ => "robots do not differ beyond their uncertainty".to_owned(),
    };
    format!(
        "{} of {} robots have it: {}, {} in the mean; {spread}. Mend the design, or its data sheet, not each robot.",
        judgement.alike,
        kind.robots.len(),
        parameter.effect.facts().name,
        value_with_sigma(judgement.mean, judgement.mean_sigma, &parameter.unit)
    )
}
