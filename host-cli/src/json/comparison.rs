//! What `compare` answers.

use robot_model::compare::{Aspect, Cell, Comparison, Drift, Label, Question, Rms, RunCompared};
use serde_json::{Value, json};

use crate::words;

/// The whole comparison.
pub fn comparison(comparison: &Comparison) -> Value {
    let both = |[position_m, heading_rad]: &[Rms; 2]| json!([rms(position_m), rms(heading_rad)]);
    json!({
        "finding": words::finding(comparison),
        "position_m": rms(&comparison.position_m),
        "heading_rad": rms(&comparison.heading_rad),
        "aside": comparison.held_out.as_ref().map(both),
        "runs": comparison.runs.iter().map(run).collect::<Vec<_>>(),
        "regimes": comparison.regimes.iter().map(question).collect::<Vec<_>>(),
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

fn question(question: &Question) -> Value {
    json!({
        "name": words::regime(question.regime),
        "cells": question.cells.iter().map(cell).collect::<Vec<_>>(),
    })
}

fn cell(cell: &Cell) -> Value {
    json!({
        "name": name(cell.label),
        "runs": cell.runs,
        "stretches": cell.stretches,
        "rolled_m": cell.rolled_m,
        "position_m": rms(&cell.position_m),
        "heading_rad": rms(&cell.heading_rad),
        "chi": cell.chi,
        "scattered": cell.scattered,
        "beyond_noise": cell.beyond_noise,
        "drifts": cell.drifts.each_ref().map(drift),
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
    let aspect = match drift.aspect {
        Aspect::Ahead => "ahead",
        Aspect::Left => "left",
        Aspect::Turn => "turn",
    };
    json!({"aspect": aspect, "per_m": drift.per_m, "sigma": drift.sigma})
}
