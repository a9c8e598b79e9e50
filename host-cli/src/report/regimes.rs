//! Where the error comes from: for each regime, the error in multiples of noise, before and after.

use std::fmt::Write;

use robot_model::compare::RegimeError;

use super::campaign_report::{self, CampaignReport, legend};
use crate::calibration_page::scale::{Px, Scale, grid_columns, nice_step, ticks};
use crate::escape::html as escape;
use crate::words;

const ROW: f64 = 21.0;
const HEAD: f64 = 30.0;
const X: (f64, f64) = (250.0, 640.0);

pub(super) fn draw(report: &CampaignReport<'_>) -> String {
    let [before, after] = report.comparisons.map(|comparison| &comparison.regimes);
    let mut html = String::new();
    legend(&mut html, campaign_report::before(report.answer), false);
    let rows: usize = before.iter().map(|grouping| grouping.groups.len()).sum();
    let bottom = 24.0 + HEAD * before.len() as f64 + ROW * rows as f64;
    let groups = before.iter().chain(after).flat_map(|grouping| &grouping.groups);
    let most = groups.map(|group| group.chi).fold(2.0, f64::max) * 1.04;
    let x = Scale::over((0.0, most), X);
    let _ = write!(
        html,
        "<div class=\"wide\"><svg class=\"d\" viewBox=\"0 0 960 {}\" role=\"img\" aria-label=\"Error by regime in multiples of noise\">\
         <rect class=\"noise\" x=\"{}\" y=\"22\" width=\"{}\" height=\"{}\"/>",
        Px(bottom + 44.0),
        Px(X.0),
        Px(x.at(1.2).0 - X.0),
        Px(bottom - 22.0)
    );
    let columns = ticks((0.0, most), nice_step(most, 6.0));
    grid_columns(&mut html, &x, columns, (22.0, bottom), bottom + 17.0);
    let _ = write!(
        html,
        "<text class=\"tick\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">times noise</text>\
         <text class=\"tick\" x=\"690\" y=\"13\">shared error, {}</text>",
        Px((X.0 + X.1) / 2.0),
        Px(bottom + 36.0),
        campaign_report::before(report.answer)
    );
    let mut y = 22.0;
    for grouping in before {
        y += HEAD;
        let _ = write!(
            html,
            "<text class=\"q\" x=\"0\" y=\"{}\">{}</text>",
            Px(y - 8.0),
            escape(words::regime(grouping.regime))
        );
        let later = after.iter().find(|other| other.regime == grouping.regime);
        for group in &grouping.groups {
            let then = later
                .and_then(|later| later.groups.iter().find(|other| other.label == group.label));
            row(&mut html, group, then, y, &x);
            y += ROW;
        }
    }
    html.push_str("</svg></div>\n");
    html
}

fn row(html: &mut String, group: &RegimeError, then: Option<&RegimeError>, y: f64, x: &Scale) {
    let middle = Px(y + 5.0);
    let from = x.at(group.chi);
    let _ = write!(
        html,
        "<text x=\"14\" y=\"{}\">{}</text>",
        Px(y + 9.5),
        escape(&words::label(group.label))
    );
    if let Some(then) = then {
        let to = x.at(then.chi);
        let _ = write!(
            html,
            "<path class=\"g\" style=\"stroke:var(--line)\" d=\"M{from} {middle}H{to}\"/><circle class=\"fb\" cx=\"{from}\" cy=\"{middle}\" r=\"4.6\"/>\
             <circle class=\"fa\" cx=\"{to}\" cy=\"{middle}\" r=\"4.6\"/>"
        );
    } else {
        let _ = write!(html, "<circle class=\"fb\" cx=\"{from}\" cy=\"{middle}\" r=\"4.6\"/>");
    }
    let drift = group.main_drift();
    if group.beyond_noise && drift.sigmas() > 3.0 {
        let _ = write!(
            html,
            "<text class=\"tick\" x=\"690\" y=\"{}\">{}</text>",
            Px(y + 9.5),
            escape(&crate::compare::drift_text(&drift))
        );
    }
}
