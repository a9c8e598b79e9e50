//! The residuals: the systematic error against each variable that it might depend on.

use std::fmt::Write;

use robot_model::compare::{Component, Curve};
use robot_model::estimation::SIGMAS_95;

use super::campaign_report::{self, CampaignReport, legend};
use crate::calibration_page::scale::{Px, Scale, grid_rows, numbers_below};

/// At most so many drawings, the largest residuals first; more only if the residuals depend on more variables.
const PANELS: usize = 6;
const X: (f64, f64) = (54.0, 452.0);
const Y: (f64, f64) = (168.0, 24.0);

pub(super) fn draw(report: &CampaignReport<'_>) -> String {
    let [before, after] = report.curves;
    // Of each variable the component with the largest residuals.
    let mut shown: Vec<&Curve> = Vec::new();
    for curve in after {
        match shown.iter_mut().find(|other| other.axis == curve.axis) {
            Some(best) if best.chi < curve.chi => *best = curve,
            Some(_) => {}
            None => shown.push(curve),
        }
    }
    let depends_on = &report.answer.unexplained.depends_on;
    let named = |curve: &Curve| depends_on.contains(&curve.axis.regressor());
    // What was named comes first, then the largest residuals.
    shown.sort_by(|a, b| named(b).cmp(&named(a)).then(b.chi.total_cmp(&a.chi)));
    let mut html = String::new();
    legend(&mut html, campaign_report::before(report.answer), false);
    html.push_str("<div class=\"pair\">");
    let panels = shown.iter().filter(|curve| named(curve)).count().max(PANELS);
    for curve in shown.into_iter().take(panels) {
        let same = |other: &&Curve| (other.axis, other.component) == (curve.axis, curve.component);
        let earlier = before.iter().find(same);
        panel(&mut html, curve, earlier, named(curve));
    }
    html.push_str("</div>\n");
    html
}

fn unit(component: Component) -> &'static str {
    match component {
        Component::Ahead => "mm/m too far ahead",
        Component::Left => "mm/m of drift to the left",
        Component::Turn => "mrad/m of turn to the left",
    }
}

fn panel(html: &mut String, curve: &Curve, earlier: Option<&Curve>, named: bool) {
    let values = |curve: &Curve| -> Vec<(f64, f64, f64)> {
        curve
            .bins
            .iter()
            .map(|bin| (bin.at, bin.drift.per_m * 1e3, bin.drift.sigma * 1e3))
            .collect()
    };
    let now = values(curve);
    let then = earlier.map(values).unwrap_or_default();
    let ends = now.iter().chain(&then).map(|(at, ..)| *at);
    let span = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    let margin = 0.04 * (span.1 - span.0).max(1e-9);
    let span = (span.0 - margin, span.1 + margin);
    let heights = now.iter().flat_map(|(_, v, s)| [v - 2.0 * s, v + 2.0 * s]);
    let heights = heights.chain(then.iter().map(|(_, value, _)| *value));
    let range = heights.fold((0.0_f64, 0.0_f64), |(a, b), y| (a.min(y), b.max(y)));
    let room = 0.06 * (range.1 - range.0).max(1e-6);
    let range = (range.0 - room, range.1 + room);
    let (x, y) = (Scale::over(span, X), Scale::over(range, Y));
    let mark = if named { "<span class=\"before\">the residuals depend on it</span>" } else { "" };
    let _ = write!(
        html,
        "<figure><figcaption><b>Against {}</b>{mark}</figcaption>\
         <svg class=\"d thin\" viewBox=\"0 0 460 194\" role=\"img\" aria-label=\"Residual against {}\">\
         <text class=\"tick\" x=\"{}\" y=\"10\">{}</text>",
        crate::words::axis(curve.axis),
        crate::words::axis(curve.axis),
        Px(X.0),
        unit(curve.component)
    );
    axes(html, (&x, span), (&y, range));
    let line = |points: &[(f64, f64, f64)]| {
        let mut data = String::new();
        for (at, value, _) in points {
            let _ = write!(
                data,
                "{}{} {}",
                if data.is_empty() { 'M' } else { 'L' },
                x.at(*at),
                y.at(*value)
            );
        }
        data
    };
    let _ = write!(
        html,
        "<path class=\"p b\" opacity=\".55\" d=\"{}\"/><path class=\"p a\" d=\"{}\"/>",
        line(&then),
        line(&now)
    );
    for (at, value, sigma) in &now {
        let half = SIGMAS_95 * sigma;
        let (cx, low, high) = (x.at(*at), y.at(value - half), y.at(value + half));
        let _ = write!(
            html,
            "<path class=\"whisker a\" d=\"M{cx} {low}V{high}\"/><circle class=\"fa\" cx=\"{cx}\" cy=\"{}\" r=\"3.4\"/>",
            y.at(*value)
        );
    }
    html.push_str("</svg></figure>");
}

/// Lines and numbers of both axes, each with its ends.
fn axes(html: &mut String, (x, span): (&Scale, (f64, f64)), (y, range): (&Scale, (f64, f64))) {
    grid_rows(html, y, range, X);
    numbers_below(html, x, span, 186, "");
}
