//! Every value in a row of its own, and the whole for programs.

use serde_json::{Value, json};

use super::{Fleet, FleetParameter, Kind, Studied, places, words};
use crate::escape::seen;
use crate::json::{judgement, pair};

/// The columns of the table.
const COLUMNS: [&str; 17] = [
    "kind",
    "robot",
    "campaign",
    "date",
    "date_by",
    "effect",
    "parameter",
    "unit",
    "value",
    "sigma",
    "low95",
    "high95",
    "trend_per_day",
    "trend_sigma",
    "trend_is_there",
    "is_unlike",
    "is_common",
];

/// One row for each campaign and parameter; what is not known is empty.
pub fn csv(fleet: &Fleet) -> String {
    let mut text = COLUMNS.join(",") + "\n";
    for kind in &fleet.kinds {
        for (number, campaign) in kind.campaigns.iter().enumerate() {
            for parameter in &kind.parameters {
                text += &row(kind, campaign, parameter, number).join(",");
                text.push('\n');
            }
        }
    }
    text
}

fn row(kind: &Kind, campaign: &Studied, parameter: &FleetParameter, number: usize) -> Vec<String> {
    let value = parameter.values[number].as_ref();
    let robot = parameter.judgement.robots.iter().find(|one| one.robot == campaign.robot);
    let trend = robot.and_then(|robot| robot.trend);
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:?}"));
    vec![
        quoted(&kind.name),
        quoted(&kind.robots[campaign.robot]),
        quoted(&campaign.folder.to_string_lossy()),
        campaign.dated.days.map_or_else(String::new, places::date),
        campaign.dated.by.to_owned(),
        parameter.effect.facts().id.to_owned(),
        parameter.name.clone(),
        quoted(&parameter.unit),
        number(value.map(|found| found.value)),
        number(value.map(|found| found.sigma)),
        number(value.map(|found| found.low95)),
        number(value.map(|found| found.high95)),
        number(trend.map(|trend| trend.per_day)),
        number(trend.map(|trend| trend.sigma)),
        trend.map_or_else(String::new, |trend| trend.is_there.to_string()),
        robot.map_or_else(String::new, |robot| robot.is_unlike.to_string()),
        parameter.judgement.is_common.to_string(),
    ]
}

/// A text as a cell: in quotes if it has what separates cells. It may come from outside, so it is inert wherever the table
/// is shown; a spreadsheet takes what begins as a formula for text after an apostrophe.
fn quoted(text: &str) -> String {
    let text = seen(text);
    let text = match text.starts_with(['=', '+', '-', '@']) {
        true => format!("'{text}"),
        false => text,
    };
    match text.contains([',', '"']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text,
    }
}

/// The whole as JSON, schema 1.
pub fn json(fleet: &Fleet) -> Value {
    let findings = words::findings_of(fleet).into_iter().map(|finding| {
        json!({
            "what": finding.what,
            "kind": finding.kind,
            "robot": finding.robot,
            "effect": finding.effect,
            "words": finding.words,
        })
    });
    let left_out = fleet.left_out.iter();
    let left_out =
        left_out.map(|(folder, why)| json!({"campaign": folder.to_string_lossy(), "why": why}));
    json!({
        "schema": 1,
        "findings": findings.collect::<Vec<_>>(),
        "kinds": fleet.kinds.iter().map(kind_json).collect::<Vec<_>>(),
        "left_out": left_out.collect::<Vec<_>>(),
    })
}

fn kind_json(kind: &Kind) -> Value {
    let campaign = |one: &Studied| {
        json!({
            "campaign": one.folder.to_string_lossy(),
            "robot": kind.robots[one.robot],
            "date": one.dated.days.map(places::date),
            "date_by": one.dated.by,
            "verdict": one.verdict,
            "missing": one.missing,
            "nominal": pair(&one.errors[0]),
            "model": pair(&one.errors[1]),
        })
    };
    json!({
        "name": kind.name,
        "robots": kind.robots,
        "campaigns": kind.campaigns.iter().map(campaign).collect::<Vec<_>>(),
        "parameters": kind.parameters.iter().map(|one| parameter_json(kind, one)).collect::<Vec<_>>(),
    })
}

fn parameter_json(kind: &Kind, parameter: &FleetParameter) -> Value {
    let values = parameter.values.iter().map(|found| {
        found.as_ref().map(|found| {
            json!({"value": found.value, "sigma": found.sigma, "low95": found.low95, "high95": found.high95})
        })
    });
    let mut json = judgement(&parameter.judgement, |robot| kind.robots[robot].clone().into());
    json["effect"] = parameter.effect.facts().id.into();
    json["parameter"] = parameter.name.clone().into();
    json["unit"] = parameter.unit.clone().into();
    json["values"] = values.collect();
    json
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_a_comma_stays_one_cell() {
        assert_eq!(quoted("a,\"b\""), "\"a,\"\"b\"\"\"");
        assert_eq!(quoted("plain"), "plain");
    }

    #[test]
    fn a_name_from_outside_is_inert() {
        assert_eq!(quoted("a\u{1b}[31m\nb\u{202e}"), r"a\u001b[31m\u000ab\u202e");
        assert_eq!(quoted("=HYPERLINK(\"x\",\"y\")"), "\"'=HYPERLINK(\"\"x\"\",\"\"y\"\")\"");
    }
}
