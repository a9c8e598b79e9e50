//! The page around the drawing: headline, table, intervals, formula, advice. One file, no script.

use std::fmt::Write;

use robot_model::calibration::WheelWeight;
use robot_model::calibration::track_fit::Estimate;
use robot_model::calibration::wheel_weight::SIGMAS_95;

use super::calibration_report::{Basis, CalibrationReport, RunReport};
use super::drawing::{COLOURS, STYLE, path_data, plan_view};
use super::scale::{Px, Scale, nice_step, number, ticks};
use crate::escape::html as escape;
use crate::quantity::{decimals, plus_minus};
use crate::words;

/// The style sheet of a page.
pub(crate) const PAGE_STYLE: &str = "\
*{box-sizing:border-box}html{color-scheme:light dark;background:var(--paper)}\
body{margin:0 auto;max-width:1000px;padding:44px 20px 60px;color:var(--ink);\
font:16px/1.5 system-ui,-apple-system,'Segoe UI',Roboto,sans-serif;font-variant-numeric:tabular-nums}\
h1{font-size:clamp(25px,5vw,34px);line-height:1.15;letter-spacing:-.02em;margin:0 0 10px;font-weight:700}\
h2{font-size:18px;margin:44px 0 10px;font-weight:650}p{margin:0 0 10px;max-width:46em}\
h1 span{white-space:nowrap}.sub{color:var(--soft)}.before{color:var(--before)}.after{color:var(--after)}\
.factor{display:inline-block;margin:0 0 6px;font-weight:650;color:var(--after)}\
svg{display:block;width:100%;height:auto;margin:14px 0 0}\
table{border-collapse:collapse;width:100%;margin-top:6px}\
th,td{padding:7px 0 7px 18px;text-align:right;border-bottom:1px solid var(--faint);font-weight:400}\
th:first-child,td:first-child{text-align:left;padding-left:0;color:var(--soft)}\
thead th{font-weight:650;border-bottom:1.5px solid var(--line)}td small{color:var(--soft);font-size:1em}\
.formula{display:flex;flex-wrap:wrap;align-items:center;gap:10px;font-size:18px;margin:14px 0;padding:16px 20px;\
border:1px solid var(--faint);border-radius:10px}.formula>span{display:inline-flex;align-items:center;gap:10px}.formula i{font-family:Georgia,'Times New Roman',serif}\
.fr{display:inline-flex;flex-direction:column;text-align:center}.fr>span{padding:1px 8px}\
.fr>span:first-child{border-bottom:1.4px solid var(--ink)}sub{font-size:.68em;line-height:0}\
.two{display:grid;grid-template-columns:1fr 1fr;gap:0 48px}@media(max-width:720px){.two{grid-template-columns:1fr}}\
.advice{border-left:4px solid var(--after);padding:2px 0 2px 16px;margin-top:16px}\
.bar{display:block;height:7px;border-radius:4px;background:var(--after);min-width:2px}td.wide{width:38%}\
.note{margin-top:8px;font-size:14px}footer{margin-top:48px;color:var(--soft);font-size:14px}\
@media(max-width:640px){body{padding-top:26px}.d text{font-size:23px}.d .t,.d .v{font-size:27px}.d .p{stroke-width:5}\
table{font-size:14px}th,td{padding-left:12px}td+td{white-space:nowrap}td.wide{width:22%}\
.formula{font-size:15px;padding:14px}}\
@media print{body{padding:0;max-width:none;font-size:13px}h1{font-size:26px}h2{break-after:avoid;margin-top:24px}svg,table,.formula{break-inside:avoid}}";

/// The whole page.
pub(super) fn page(report: &CalibrationReport) -> String {
    let name = escape(&report.robot_name);
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <title>{name}: calibration</title>\n<style>{COLOURS}\n{STYLE}\n{PAGE_STYLE}</style></head>\n<body>\n"
    );
    header(&mut html, report, &name);
    html.push_str(&plan_view(report, "", ""));
    html.push_str("\n<h2>Off the line, in mm, over the distance in m</h2>\n");
    html.push_str(&deviations(report));
    html.push_str("\n<h2>Before and after</h2>\n");
    table(&mut html, report);
    html.push_str("\n<h2>How sure is W<sub>T</sub>?</h2>\n");
    html.push_str(&intervals(report));
    budget(&mut html, &report.before.wheel_weight);
    formula(&mut html, report);
    decided(&mut html, report);
    if let Some(out_and_back) = &report.out_and_back {
        let _ = write!(
            html,
            "\n<h2>Out and back</h2>\n<p>{}.</p><p class=\"sub\">From the part of the curvature that changes sign: W<sub>T</sub> = {}. \
             Pull: {} mrad per metre, to the right positive.</p>",
            escape(&capitalised(words::out_and_back(out_and_back.verdict))),
            plus_minus(out_and_back.wheel_weight, out_and_back.wheel_weight_sigma),
            plus_minus(out_and_back.pull_rad_per_m * 1e3, out_and_back.pull_sigma_rad_per_m * 1e3)
        );
    }
    footer(&mut html, report);
    html.push_str("</body></html>\n");
    html
}

fn header(html: &mut String, report: &CalibrationReport, name: &str) {
    let off_mm = |run: &RunReport| run.end.lateral_offset_m.abs() * 1e3;
    let (before, after) = (off_mm(&report.before), off_mm(&report.after));
    let claim = report.claim();
    let gain = gain(before, after, report.after.end.lateral_offset_sigma_m * 1e3);
    let gain = gain.map_or_else(String::new, |gain| format!("<p class=\"factor\">{gain}</p>"));
    let profile = &report.profile;
    let _ = write!(
        html,
        "<p class=\"sub\">{name} \u{b7} {}</p>\n<h1>{claim}: <span class=\"before\">{} mm</span> off before, \
         <span class=\"after\">{} mm</span> after</h1>\n{gain}<p class=\"sub\">{}: {} m in {} s, \
         ramps of {} rev/s\u{b2}, cruise at {} rev/s.</p>\n",
        escape(&report.port),
        number(before, 1),
        number(after, 1),
        driven(report.drives),
        number(profile.distance_m, 4),
        number(profile.duration_s, 3),
        number(profile.acceleration_rev_per_s2, 3),
        number(profile.cruise_rev_per_s, 3)
    );
}

fn driven(drives: u32) -> String {
    match drives {
        2 => "Driven twice".into(),
        drives => format!("Driven {drives} times"),
    }
}

/// How much closer to the line the robot ends, as a sentence; `None` if not even twice as close.
///
/// An offset whose 95 % interval contains zero supports no factor.
fn gain(before_mm: f64, after_mm: f64, after_sigma_mm: f64) -> Option<String> {
    if before_mm < 2.0 * after_mm.max(after_sigma_mm) {
        return None;
    }
    if after_mm < SIGMAS_95 * after_sigma_mm {
        let noise = number(SIGMAS_95 * after_sigma_mm, 1);
        return Some(format!(
            "on the line, as far as this measurement can tell (95 %: \u{b1} {noise} mm)"
        ));
    }
    let factor = before_mm / after_mm;
    let places = if factor < 10.0 { 1 } else { 0 };
    Some(format!("{} times closer to the line", number(factor, places)))
}

/// Lateral deviation against distance, both runs on one axis.
fn deviations(report: &CalibrationReport) -> String {
    let runs = [(&report.before, 'b', "before"), (&report.after, 'a', "after")];
    let (mut along, mut aside) = ((0.0_f64, 0.05_f64), (-0.002_f64, 0.002_f64));
    for pose in runs.iter().flat_map(|(run, ..)| &run.path) {
        if pose.x_m.is_finite() && pose.y_m.is_finite() {
            along = (along.0.min(pose.x_m), along.1.max(pose.x_m));
            aside = (aside.0.min(pose.y_m), aside.1.max(pose.y_m));
        }
    }
    let (x, y) = (Scale::over(along, (64.0, 866.0)), Scale::over(aside, (150.0, 14.0)));
    let mut svg =
        "<svg class=\"d\" viewBox=\"0 0 960 190\" role=\"img\" aria-label=\"Lateral deviation against distance\">"
            .to_owned();
    let mm = (aside.0 * 1e3, aside.1 * 1e3);
    let (levels, places) = ticks(mm, nice_step(mm.1 - mm.0, 5.0));
    for level in levels {
        let at = y.at(level / 1e3);
        let class = if level == 0.0 { "r" } else { "g" };
        let _ = write!(
            svg,
            "<path class=\"{class}\" d=\"M64 {at}H866\"/><text x=\"54\" y=\"{}\" text-anchor=\"end\">{}</text>",
            Px(at.0 + 4.5),
            number(level, places)
        );
    }
    let (metres, places) = ticks(along, nice_step(along.1 - along.0, 8.0));
    for metre in metres {
        let at = x.at(metre);
        let text = number(metre, places);
        let _ = write!(svg, "<text x=\"{at}\" y=\"180\" text-anchor=\"middle\">{text}</text>");
    }
    let mut labels: Vec<(f64, char, &str)> = Vec::new();
    for (run, class, name) in runs {
        let data = path_data(&run.path, &x, &y);
        let _ = write!(svg, "<path class=\"p {class}\" d=\"{data}\"/>");
        if let Some(end) = run.path.last() {
            labels.push((y.at(end.y_m).0, class, name));
        }
    }
    // Two labels must be a line apart.
    labels.sort_by(|a, b| a.0.total_cmp(&b.0));
    if let [a, b] = labels.as_mut_slice() {
        let lacking = (18.0 - (b.0 - a.0)).max(0.0) / 2.0;
        (a.0, b.0) = (a.0 - lacking, b.0 + lacking);
    }
    for (at, class, name) in labels {
        let _ = write!(
            svg,
            "<text class=\"v f{class}\" x=\"876\" y=\"{}\">{name}</text>",
            Px(at + 5.0)
        );
    }
    svg.push_str("</svg>");
    svg
}

fn table(html: &mut String, report: &CalibrationReport) {
    html.push_str(
        "<table><thead><tr><th></th><th class=\"before\">before</th><th class=\"after\">after</th></tr></thead><tbody>",
    );
    let mut row = |name: &str, cell: &dyn Fn(&RunReport) -> String| {
        let (before, after) = (cell(&report.before), cell(&report.after));
        let _ = write!(html, "<tr><td>{name}</td><td>{before}</td><td>{after}</td></tr>");
    };
    row("driven with W<sub>T</sub>", &|run| number(run.driven_with, 6));
    row("lateral offset at the end", &|run| {
        measured(run.end.lateral_offset_m * 1e3, run.end.lateral_offset_sigma_m * 1e3, "mm")
    });
    row("heading at the end", &|run| {
        measured(run.end.heading_rad * 1e3, run.end.heading_sigma_rad * 1e3, "mrad")
    });
    row("deviation angle \u{3b1}", &|run| {
        measured(run.wheel_weight.alpha_rad * 1e3, run.wheel_weight.alpha_sigma_rad * 1e3, "mrad")
    });
    row("W<sub>T</sub> by this run", &|run| {
        measured(run.wheel_weight.value, run.wheel_weight.sigma, "")
    });
    row("R<sub>R</sub> by that", &|run| {
        format!("{} cm", number(run.wheel_weight.right_radius_m(&report.geometry) * 100.0, 4))
    });
    html.push_str(
        "</tbody></table>\n<p class=\"sub note\">Offset and heading are positive to the left, \u{3b1} to the right.</p>",
    );
}

/// Value and sigma, the sigma in a softer colour.
fn measured(value: f64, sigma: f64, unit: &str) -> String {
    let places = decimals(sigma).min(6);
    format!("{} <small>\u{b1} {} {unit}</small>", number(value, places), number(sigma, places))
}

/// The text with a capital letter at its start.
fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The 95 % intervals of both runs, and the W_T with which each was driven.
fn intervals(report: &CalibrationReport) -> String {
    let runs = [(&report.before, 'b', "before", 34.0), (&report.after, 'a', "after", 84.0)];
    let values = runs.iter().flat_map(|(run, ..)| {
        [run.wheel_weight.low95, run.wheel_weight.high95, run.wheel_weight.value, run.driven_with]
    });
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    let pad = ((high - low) * 0.06).max(1e-6);
    let range = (low - pad, high + pad);
    let x = Scale::over(range, (90.0, 930.0));
    let mut svg = "<svg class=\"d\" viewBox=\"0 0 960 170\" role=\"img\" aria-label=\"95 percent intervals of the wheel weight\">".to_owned();
    let (levels, places) = ticks(range, nice_step(range.1 - range.0, 7.0));
    for level in levels {
        let at = x.at(level);
        let text = number(level, places);
        let _ = write!(
            svg,
            "<path class=\"g\" d=\"M{at} 12V112\"/><text x=\"{at}\" y=\"131\" text-anchor=\"middle\">{text}</text>"
        );
    }
    for (run, class, name, y) in runs {
        let weight = &run.wheel_weight;
        let (low, high, value) = (x.at(weight.low95), x.at(weight.high95), x.at(weight.value));
        let driven = x.at(run.driven_with);
        let _ = write!(
            svg,
            "<text class=\"v f{class}\" x=\"0\" y=\"{4}\">{name}</text>\
             <path class=\"p {class}\" d=\"M{low} {0}H{high}M{low} {1}V{2}M{high} {1}V{2}\"/>\
             <circle class=\"f{class}\" cx=\"{value}\" cy=\"{0}\" r=\"5.5\"/>\
             <path class=\"body {class}\" d=\"M{driven} {3}l-6 -11h12z\"/>",
            Px(y),
            Px(y - 6.0),
            Px(y + 6.0),
            Px(y - 9.0),
            Px(y + 5.0)
        );
    }
    svg.push_str(
        "<text x=\"90\" y=\"161\">\u{25cf} measured, with its 95 % interval \u{2003} \u{25bd} driven with</text>\
         <text x=\"930\" y=\"161\" text-anchor=\"end\">W<tspan dy=\"3\" font-size=\".7em\">T</tspan></text></svg>",
    );
    svg
}

/// The contributions to the uncertainty, and what would reduce it.
fn budget(html: &mut String, weight: &WheelWeight) {
    html.push_str(
        "<table><thead><tr><th>uncertainty of the first run</th><th>\u{3c3}(W<sub>T</sub>)</th>\
         <th>share</th><th></th></tr></thead><tbody>",
    );
    let places = (decimals(weight.sigma) + 1).min(8);
    for part in &weight.contributions {
        let share = 100.0 * (part.sigma / weight.sigma).powi(2);
        let _ = write!(
            html,
            "<tr><td>{}</td><td>{}</td><td>{} %</td><td class=\"wide\"><span class=\"bar\" style=\"width:{}%\"></span></td></tr>",
            words::source(part.source),
            number(part.sigma, places),
            number(share, 0),
            Px(share)
        );
    }
    html.push_str("</tbody></table>");
    let advice = words::advice(&weight.advice);
    let _ = write!(
        html,
        "<p class=\"advice\">{}.</p>",
        escape(&advice).replace("W_T", "W<sub>T</sub>")
    );
}

/// Equation (3-6) in its general form, with the numbers of the first run.
fn formula(html: &mut String, report: &CalibrationReport) {
    let weight = &report.before.wheel_weight;
    let radius_cm = number(report.geometry.wheel_radius_m * 100.0, 3);
    let track_cm = number(report.geometry.track_width_m * 100.0, 2);
    let (left, right) = (weight.turns.left, weight.turns.right);
    let _ = write!(
        html,
        "\n<h2>The calculation</h2>\n<div class=\"formula\"><span><span><i>W</i><sub>T</sub></span>=\
         <span class=\"fr\"><span><i>R</i><sub>L</sub> <i>\u{3c6}</i><sub>L</sub> \u{2212} <i>b \u{3b1}</i></span>\
         <span><i>R</i><sub>L</sub> <i>\u{3c6}</i><sub>R</sub></span></span></span><span>=\
         <span class=\"fr\"><span>{radius_cm} cm \u{b7} {} \u{2212} {track_cm} cm \u{b7} {}</span>\
         <span>{radius_cm} cm \u{b7} {}</span></span></span><span>=<b>{}</b></span></div>\n\
         <p class=\"sub\">R<sub>L</sub>: radius of the left wheel; b: distance between the wheels; \
         \u{3c6}: angles that the wheels turned, in rad; \u{3b1}: deviation angle in rad, to the right positive. \
         W<sub>T</sub> = R<sub>R</sub> / R<sub>L</sub>, so R<sub>R</sub>\u{a0}=\u{a0}{}\u{a0}cm.</p>",
        number(left, 3),
        number(weight.alpha_rad, 5),
        number(right, 3),
        plus_minus(weight.value, weight.sigma),
        number(weight.right_radius_m(&report.geometry) * 100.0, 4)
    );
}

/// The W_T that was written, if it does not come from the first run alone.
fn decided(html: &mut String, report: &CalibrationReport) {
    if report.basis == Basis::OneRun {
        return;
    }
    let Estimate { value, sigma } = report.wheel_weight;
    let _ = write!(
        html,
        "\n<p><b>Written: W<sub>T</sub> = {}</b>, from {}; R<sub>R</sub>\u{a0}=\u{a0}{}\u{a0}cm.</p>",
        plus_minus(value, sigma),
        report.basis,
        number(value * report.geometry.wheel_radius_m * 100.0, 4)
    );
}

fn footer(html: &mut String, report: &CalibrationReport) {
    let sources = [&report.before, &report.after].map(|run| run.path_source.sentence());
    let lines = match sources {
        [before, after] if before == after => format!("Paths: {before}"),
        [before, after] => format!("Path before: {before}; after: {after}"),
    };
    let _ = write!(html, "\n<footer>{lines}. \u{b1} is one standard uncertainty.</footer>\n");
}
