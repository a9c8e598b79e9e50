//! The error on held-out runs as one effect after the other is added.

use std::fmt::Write;

use robot_model::answer::Errors;

use super::CampaignReport;
use crate::picture::scale::{Px, Scale, escape, nice_step, number, ticks};
use crate::quantity::probability;

/// Height of a row, and where the columns of bars begin.
const ROW: f64 = 34.0;
const TOP: f64 = 30.0;
const POSITION: (f64, f64) = (300.0, 590.0);
const HEADING: (f64, f64) = (680.0, 900.0);

pub(super) fn draw(report: &CampaignReport<'_>) -> String {
    let answer = report.answer;
    let mut rows: Vec<(String, String, Errors, Errors)> = vec![(
        "nominal robot".into(),
        String::new(),
        answer.baseline.train,
        answer.baseline.heldout,
    )];
    for step in &answer.steps {
        let names: Vec<&str> = step.class.iter().map(|id| report.subject.name(id)).collect();
        let name = match names.as_slice() {
            [one] => format!("+ {one}"),
            [one, ..] => format!("+ {one} or {} more", names.len() - 1),
            [] => format!("+ {}", step.effect),
        };
        let p = format!("p = {}", probability(step.p_value).replace("< ", "less than "));
        rows.push((name, p, step.train, step.heldout));
    }
    let bottom = TOP + ROW * rows.len() as f64;
    let mut svg = format!(
        "<svg class=\"d\" viewBox=\"0 0 960 {}\" role=\"img\" aria-label=\"Error on held-out runs as effects are added\">",
        Px(bottom + 30.0)
    );
    let most = |of: fn(&Errors) -> f64| {
        rows.iter().flat_map(|it| [of(&it.2), of(&it.3)]).fold(1e-9, f64::max) * 1e3
    };
    type Column = (&'static str, (f64, f64), fn(&Errors) -> f64);
    let columns: [Column; 2] = [
        ("position, mm", POSITION, |it| it.position_rms_m),
        ("heading, mrad", HEADING, |it| it.heading_rms_rad),
    ];
    for (title, (from, to), of) in columns {
        let x = Scale::over((0.0, most(of)), (from, to));
        let (levels, places) = ticks((0.0, most(of)), nice_step(most(of), 4.0));
        let _ = write!(svg, "<text class=\"q\" x=\"{}\" y=\"14\">{title}</text>", Px(from));
        for level in levels {
            let at = x.at(level);
            let _ = write!(
                svg,
                "<path class=\"g\" d=\"M{at} {}V{}\"/><text class=\"tick\" x=\"{at}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                Px(TOP - 6.0),
                Px(bottom),
                Px(bottom + 18.0),
                number(level, places)
            );
        }
        for (k, (.., train, heldout)) in rows.iter().enumerate() {
            let y = TOP + ROW * k as f64;
            let class = if k == 0 { 'b' } else { 'a' };
            let (held, fitted) = (of(heldout) * 1e3, of(train) * 1e3);
            let end = x.at(held);
            let _ = write!(
                svg,
                "<rect class=\"f{class}\" x=\"{x0}\" y=\"{y0}\" width=\"{w}\" height=\"18\" rx=\"3\"/>\
                 <path class=\"body\" style=\"stroke:var(--ink)\" d=\"M{t} {y1}v26\"/>\
                 <text class=\"v\" x=\"{tx}\" y=\"{ty}\" style=\"fill:var(--ink);font-size:14px\">{}</text>",
                number(held, 1),
                x0 = Px(from),
                y0 = Px(y),
                w = Px((end.0 - from).max(1.5)),
                t = x.at(fitted),
                y1 = Px(y - 4.0),
                tx = Px(end.0.max(x.at(fitted).0) + 8.0),
                ty = Px(y + 14.0),
            );
        }
    }
    for (k, (name, p, ..)) in rows.iter().enumerate() {
        let y = TOP + ROW * k as f64;
        let _ = write!(
            svg,
            "<text x=\"0\" y=\"{}\" style=\"fill:var(--ink)\">{}</text><text class=\"tick\" x=\"14\" y=\"{}\">{p}</text>",
            Px(y + if p.is_empty() { 14.0 } else { 8.0 }),
            escape(&shortened(name)),
            Px(y + 22.0)
        );
    }
    svg.push_str("</svg>\n");
    svg
}

/// A name that fits before the bars.
fn shortened(name: &str) -> String {
    if name.chars().count() <= 42 {
        return name.to_owned();
    }
    name.chars().take(41).chain(['\u{2026}']).collect()
}
