//! `beeline compare` in words and tables. What is compared, and how, is in [`robot_model::compare`].

use anstyle::Style;
use robot_model::compare::{Comparison, Component, Drift, Rms, RunCompared};

use crate::table::{Cell, Table, wrapped};
use crate::ui::{self, BAD, BOLD, DIM, paint, say};
use crate::words;

/// A systematic error of more sigmas is shown in full strength.
const SURE_SIGMAS: f64 = 4.0;
/// Longest line of a paragraph.
pub const LINE: usize = 96;

/// Prints a comparison; `nominal` is that of the nominal robot, if the model is not it.
pub fn show(comparison: &Comparison, nominal: Option<&Comparison>) {
    for line in wrapped(&words::finding(comparison), LINE) {
        say(paint(BOLD, line));
    }
    say("");
    runs(comparison, nominal);
    say("");
    say(paint(BOLD, "Where the error arises"));
    let words = "Each run is cut into stretches where the regime changes, and at least every half metre. Position and \
                 heading: root mean square error of the predicted move over a stretch, beside what noise alone \
                 gives. Last column: the error that all stretches share, per metre of wheel travel; it can be \
                 significant (drift) where each stretch alone looks like noise.";
    wrapped(words, LINE).iter().for_each(|line| say(paint(DIM, line)));
    say("");
    regimes(comparison);
}

fn runs(comparison: &Comparison, nominal: Option<&Comparison>) {
    let mut table = Table::new("llrrrrrrrr");
    let dim = |text: &str| Cell::styled(DIM, text);
    let heads =
        ["run", "kind", "path", "position", "noise", "", "at the end", "heading", "noise", ""];
    table.row(heads.map(dim));
    for run in &comparison.runs {
        let mut row: Vec<Cell> = vec![
            run.name.clone().into(),
            kind_of(run).into(),
            format!("{:.1} m", run.path_m).into(),
        ];
        row.extend(cells(run.position_m.as_ref(), "mm"));
        row.push(
            run.end_m.map_or_else(|| dim("-"), |end_m| format!("{:.1} mm", end_m * 1e3).into()),
        );
        row.extend(cells(run.heading_rad.as_ref(), "mrad"));
        table.row(row);
    }
    let mut total = |name: &str, of: &Comparison, held_out: bool, rms: &[Rms; 2]| {
        let runs: Vec<_> = of.runs.iter().filter(|run| run.held_out == held_out).collect();
        let path_m: f64 = runs.iter().map(|run| run.path_m).sum();
        let name = Cell::styled(BOLD, format!("{name} {}", ui::runs(runs.len())));
        let mut row = vec![name, "".into(), format!("{path_m:.1} m").into()];
        row.extend(cells(Some(&rms[0]), "mm"));
        row.push("".into());
        row.extend(cells(Some(&rms[1]), "mrad"));
        table.row(row);
    };
    for (before, of) in [("", Some(comparison)), ("nominal, ", nominal)] {
        let Some(of) = of else { continue };
        let all = if of.held_out.is_some() { "all other" } else { "all" };
        total(&format!("{before}{all}"), of, false, &[of.position_m, of.heading_rad]);
        if let Some(held_out) = &of.held_out {
            total(&format!("{before}held out,"), of, true, held_out);
        }
    }
    table.say(0);
}

/// The kind of a run, and whether it is held out.
fn kind_of(run: &RunCompared) -> String {
    match run.held_out {
        true => format!("{}, held out", run.kind.name()),
        false => run.kind.name().to_owned(),
    }
}

/// Error, noise, and their ratio.
fn cells(rms: Option<&Rms>, unit: &str) -> [Cell; 3] {
    let Some(rms) = rms.filter(|rms| rms.rms > 0.0) else {
        return [Cell::styled(DIM, "-"), "".into(), "".into()];
    };
    [
        format!("{:.1} {unit}", rms.rms * 1e3).into(),
        Cell::styled(DIM, format!("{:.1}", rms.noise * 1e3)),
        times(rms.rms / rms.noise, rms.beyond_noise()),
    ]
}

fn times(ratio: f64, beyond: bool) -> Cell {
    if beyond { Cell::styled(BAD, format!("{ratio:.1}x")) } else { Cell::styled(DIM, "noise") }
}

fn regimes(comparison: &Comparison) {
    let mut table = Table::new("lrrrrrrrl");
    let heads = [
        "",
        "runs",
        "stretches",
        "position",
        "noise",
        "heading",
        "noise",
        "",
        "systematic, per metre",
    ];
    table.row(heads.map(|text| Cell::styled(DIM, text)));
    for grouping in &comparison.regimes {
        table.row([Cell::styled(BOLD, words::regime(grouping.regime))]);
        for group in &grouping.groups {
            let mm = |value: f64| format!("{:.1}", value * 1e3);
            table.row([
                format!("  {}", words::label(group.label)).into(),
                group.runs.into(),
                group.stretches.into(),
                format!("{} mm", mm(group.position_m.rms)).into(),
                Cell::styled(DIM, mm(group.position_m.noise)),
                format!("{} mrad", mm(group.heading_rad.rms)).into(),
                Cell::styled(DIM, mm(group.heading_rad.noise)),
                match (group.scattered, group.beyond_noise) {
                    (false, true) => Cell::styled(BAD, "drift"),
                    _ => times(group.chi, group.scattered),
                },
                systematic(&group.main_drift()),
            ]);
        }
    }
    table.say(0);
}

fn systematic(drift: &Drift) -> Cell {
    if drift.sigma <= 0.0 {
        return "".into();
    }
    let style = if drift.sigmas() > SURE_SIGMAS { Style::new() } else { DIM };
    Cell::styled(style, drift_text(drift))
}

/// `12.3 ± 0.4 mrad/m to the left`.
pub fn drift_text(drift: &Drift) -> String {
    let value = crate::quantity::plus_minus(drift.per_m.abs() * 1e3, drift.sigma * 1e3);
    match (drift.component, drift.per_m > 0.0) {
        (Component::Turn, true) => format!("{value} mrad/m to the left"),
        (Component::Turn, false) => format!("{value} mrad/m to the right"),
        (Component::Ahead, true) => format!("{value} mm/m too far"),
        (Component::Ahead, false) => format!("{value} mm/m too short"),
        (Component::Left, true) => format!("{value} mm/m drift to the left"),
        (Component::Left, false) => format!("{value} mm/m drift to the right"),
    }
}
