//! What `compare` answers.

use robot_model::compare::{
    Comparison, Component, Drift, Grouping, Label, RegimeError, Rms, RunCompared,
};
use serde_json::{Value, json};

use crate::words;

/// What `compare` answers: a model of these effects compared with the campaign, and the nominal robot if that is another.
pub fn compared(effects: &[&str], comparison: &Comparison, nominal: Option<&Comparison>) -> Value {
    let nominal = nominal.map(|nominal| {
        json!({
            "position_m": rms(&nominal.position_m),
            "heading_rad": rms(&nominal.heading_rad),
        })
    });
    json!({
        "schema": 1,
        "model": effects,
        "comparison": self::comparison(comparison),
        "nominal": nominal,
    })
}

/// The whole comparison.
pub fn comparison(comparison: &Comparison) -> Value {
    let both = |[position_m, heading_rad]: &[Rms; 2]| json!([rms(position_m), rms(heading_rad)]);
    json!({
        "finding": words::finding(comparison),
        "position_m": rms(&comparison.position_m),
        "heading_rad": rms(&comparison.heading_rad),
        "aside": comparison.held_out.as_ref().map(both),
        "runs": comparison.runs.iter().map(run).collect::<Vec<_>>(),
        "regimes": comparison.regimes.iter().map(grouping).collect::<Vec<_>>(),
    })
}

/// A root mean square, beside what noise alone gives.
pub fn rms(rms: &Rms) -> Value {
    json!({"rms": rms.rms, "noise": rms.noise, "noise_high": rms.noise_high})
}

fn run(run: &RunCompared) -> Value {
    json!({
        "name": run.name,
        "kind": run.kind.name(),
        "held_out": run.held_out,
        "path_m": run.path_m,
        "turned_rad": run.turned_rad,
        "duration_s": run.duration_s,
        "position_m": run.position_m.as_ref().map(rms),
        "heading_rad": run.heading_rad.as_ref().map(rms),
        "end_m": run.end_m,
    })
}

fn grouping(grouping: &Grouping) -> Value {
    json!({
        "name": words::regime(grouping.regime),
        "cells": grouping.groups.iter().map(group).collect::<Vec<_>>(),
    })
}

fn group(group: &RegimeError) -> Value {
    json!({
        "name": name(group.label),
        "runs": group.runs,
        "stretches": group.stretches,
        "rolled_m": group.rolled_m,
        "position_m": rms(&group.position_m),
        "heading_rad": rms(&group.heading_rad),
        "chi": group.chi,
        "scattered": group.scattered,
        "beyond_noise": group.beyond_noise,
        "drifts": group.drifts.each_ref().map(drift),
    })
}

/// The name of a kind of stretches. Programs compare it, so a heading keeps the name that it has had.
fn name(label: Label) -> String {
    match label {
        Label::Facing(deg) => format!("round {deg} deg"),
        other => words::label(other),
    }
}

fn drift(drift: &Drift) -> Value {
    let component = match drift.component {
        Component::Ahead => "ahead",
        Component::Left => "left",
        Component::Turn => "turn",
    };
    json!({"aspect": component, "per_m": drift.per_m, "sigma": drift.sigma})
}
