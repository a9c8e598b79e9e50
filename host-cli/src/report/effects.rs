//! Each effect that was found: the evidence, its values with intervals, the remedy.

use std::fmt::Write;

use robot_model::explain::{ParameterFound, StepFound};

use super::campaign_report::CampaignReport;
use crate::calibration_page::scale::{Px, Scale, nice_step, number, ticks};
use crate::escape::html as escape;
use crate::quantity::{scaled_unit, value_with_sigma};

pub(super) fn draw(report: &CampaignReport<'_>) -> String {
    let mut html = String::new();
    for (index, step) in report.answer.steps.iter().enumerate() {
        card(&mut html, report, index, step);
    }
    html
}

fn card(html: &mut String, report: &CampaignReport<'_>, index: usize, step: &StepFound) {
    let context = report.context;
    let names: Vec<&str> = step.class.iter().map(|id| context.name(id)).collect();
    let mut name = names.join(" or ");
    if let Some(first) = name.get(..1) {
        name = first.to_uppercase() + &name[1..];
    }
    let _ = write!(
        html,
        "<div class=\"card\"><h3><span class=\"n\">{}</span>{}</h3><span class=\"ids\">{}</span>",
        index + 1,
        escape(&name),
        escape(&step.class.join(" or "))
    );
    let facts = context.facts(&step.effect);
    if let Some(facts) = facts {
        let _ = write!(html, "<p><code>{}</code></p>", escape(facts.equation));
    }
    html.push_str(&intervals(&step.parameters));
    let _ = write!(
        html,
        "<p>Evidence: {}.</p>",
        escape(crate::words::evidence(step).trim_end_matches('.'))
    );
    let combination = context.combinations.get(index).and_then(Option::as_deref);
    if step.class.len() > 1 {
        let common = combination.map_or_else(String::new, |change| {
            format!(" Their combined effect: {}.", escape(change))
        });
        let _ = write!(
            html,
            "<p class=\"class\">These runs cannot tell {} apart.{common}</p>",
            escape(&crate::words::listed(&step.class))
        );
    } else if let Some(change) = combination {
        let _ = write!(html, "<p class=\"sub\">In these runs: {}.</p>", escape(change));
    }
    if let Some(facts) = facts.filter(|facts| !facts.compensation.is_empty()) {
        let _ = write!(html, "<p class=\"sub\">Remedy: {}.</p>", escape(facts.compensation));
    }
    html.push_str("</div>\n");
}

/// Where the intervals are on a page.
struct Layout {
    class: &'static str,
    width: f64,
    /// The height of a parameter, and where its axis is in it.
    row: f64,
    axis: f64,
    /// Where its value stands, and where its axis begins and ends.
    value: f64,
    span: (f64, f64),
    /// So many numbers along the axis.
    ticks: f64,
}

const WIDE: Layout = Layout {
    class: "only-wide",
    width: 960.0,
    row: 44.0,
    axis: 16.0,
    value: 110.0,
    span: (420.0, 930.0),
    ticks: 6.0,
};

/// For a telephone: the value stands above its axis.
const NARROW: Layout = Layout {
    class: "only-narrow",
    width: 350.0,
    row: 74.0,
    axis: 40.0,
    value: 60.0,
    span: (12.0, 338.0),
    ticks: 4.0,
};

/// Values with their 95 % intervals, each against its own zero.
fn intervals(parameters: &[ParameterFound]) -> String {
    [WIDE, NARROW].map(|layout| intervals_as(parameters, &layout)).concat()
}

fn intervals_as(parameters: &[ParameterFound], layout: &Layout) -> String {
    let mut svg = format!(
        "<svg class=\"d {}\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"Values with 95 percent intervals\">",
        layout.class,
        Px(layout.width),
        Px(layout.row * parameters.len() as f64 + 4.0)
    );
    for (k, parameter) in parameters.iter().enumerate() {
        let top = layout.row * k as f64;
        let y = top + layout.axis;
        let (factor, _) = scaled_unit(parameter.value.abs().max(parameter.sigma), &parameter.unit);
        let (low, high) = (parameter.low95.min(0.0) * factor, parameter.high95.max(0.0) * factor);
        let pad = 0.06 * (high - low).max(1e-12);
        let range = (low - pad, high + pad);
        let x = Scale::over(range, layout.span);
        let (levels, places) = ticks(range, nice_step(range.1 - range.0, layout.ticks));
        let _ = write!(
            svg,
            "<text x=\"0\" y=\"{ty}\" style=\"fill:var(--ink)\"><tspan font-weight=\"650\">{}</tspan></text>\
             <text x=\"{}\" y=\"{ty}\" style=\"fill:var(--ink)\">{}</text><path class=\"g\" d=\"M{} {y}H{}\"/>",
            escape(&parameter.name),
            Px(layout.value),
            escape(&value_with_sigma(parameter.value, parameter.sigma, &parameter.unit)),
            Px(layout.span.0),
            Px(layout.span.1),
            ty = Px(top + 21.0),
            y = Px(y)
        );
        for level in levels {
            let at = x.at(level);
            let class = if level == 0.0 { "zero" } else { "g" };
            let _ = write!(
                svg,
                "<path class=\"{class}\" d=\"M{at} {}v{}\"/><text class=\"tick\" x=\"{at}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                Px(y - 8.0),
                Px(16.0),
                Px(y + 23.0),
                number(level, places)
            );
        }
        let _ = write!(
            svg,
            "<path class=\"p a\" d=\"M{0} {3}H{1}M{0} {4}v10M{1} {4}v10\"/><circle class=\"fa\" cx=\"{2}\" cy=\"{3}\" r=\"5\"/>",
            x.at(parameter.low95 * factor),
            x.at(parameter.high95 * factor),
            x.at(parameter.value * factor),
            Px(y),
            Px(y - 5.0),
        );
    }
    svg.push_str("</svg>");
    svg
}
