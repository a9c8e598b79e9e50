//! The cross-validated error as one effect after the other is added.

use std::fmt::Write;

use robot_model::estimation::Errors;

use super::CampaignReport;
use crate::picture::scale::{Px, Scale, escape, nice_step, number, ticks};
use crate::quantity::p_value;
use crate::table::wrapped;

/// Width of the drawing, and where the columns of bars begin and end.
pub(super) const WIDTH: f64 = 960.0;
const POSITION: (f64, f64) = (300.0, 590.0);
const HEADING: (f64, f64) = (680.0, 900.0);
/// Where the rows begin; the height of a bar, and of a line of text.
const TOP: f64 = 30.0;
const BAR: f64 = 18.0;
const LINE: f64 = 15.0;
/// So many letters fit before the bars, in so many lines.
const LETTERS: usize = 40;
const LINES: usize = 3;

/// A model: its name in lines, how likely by chance, its errors, and where it is drawn.
struct Row {
    name: Vec<String>,
    p: String,
    fitted: Errors,
    cross_validated: Errors,
    y: f64,
}

impl Row {
    fn height(&self) -> f64 {
        let lines = self.name.len() + usize::from(!self.p.is_empty());
        (lines as f64 * LINE).max(BAR) + 10.0
    }
}

pub(super) fn draw(report: &CampaignReport<'_>) -> String {
    let (height, lines) = drawing(report);
    format!(
        "<div class=\"wide\"><svg class=\"d\" viewBox=\"0 0 {} {}\" role=\"img\" \
         aria-label=\"Error as effects are added\">{lines}</svg></div>\n",
        Px(WIDTH),
        Px(height)
    )
}

/// Its height, and its lines.
pub(super) fn drawing(report: &CampaignReport<'_>) -> (f64, String) {
    let rows = rows(report);
    let bottom = rows.last().map_or(TOP, |row| row.y + row.height());
    let mut svg = String::new();
    column(&mut svg, &rows, bottom, "position, mm", POSITION, |errors| errors.position_rms_m * 1e3);
    column(&mut svg, &rows, bottom, "heading, mrad", HEADING, |errors| {
        errors.heading_rms_rad * 1e3
    });
    for row in &rows {
        for (k, line) in row.name.iter().enumerate() {
            let _ = write!(
                svg,
                "<text x=\"{}\" y=\"{}\" style=\"fill:var(--ink)\">{}</text>",
                Px(if k == 0 { 0.0 } else { 14.0 }),
                Px(row.y + 13.0 + LINE * k as f64),
                escape(line)
            );
        }
        let below = row.y + 13.0 + LINE * row.name.len() as f64;
        let _ = write!(svg, "<text class=\"tick\" x=\"14\" y=\"{}\">{}</text>", Px(below), row.p);
    }
    (bottom + 24.0, svg)
}

fn rows(report: &CampaignReport<'_>) -> Vec<Row> {
    let answer = report.answer;
    let mut rows = vec![Row {
        name: vec![super::before(answer).into()],
        p: String::new(),
        fitted: answer.baseline.fitted,
        cross_validated: answer.baseline.cross_validated,
        y: TOP,
    }];
    for step in &answer.steps {
        let names: Vec<&str> = step.class.iter().map(|id| report.subject.name(id)).collect();
        let mut name = wrapped(&format!("+ {}", names.join(" or ")), LETTERS);
        if name.len() > LINES {
            name.truncate(LINES);
            name[LINES - 1].push_str(" \u{2026}");
        }
        let p = p_value(step.p_value).replace('<', "&lt;");
        let y = rows.last().map_or(TOP, |row| row.y + row.height());
        rows.push(Row { name, p, fitted: step.fitted, cross_validated: step.cross_validated, y });
    }
    let y = rows.last().map_or(TOP, |row| row.y + row.height());
    rows.push(Row {
        name: vec!["error floor: any model at all".into()],
        p: String::new(),
        fitted: answer.floor,
        cross_validated: answer.floor,
        y,
    });
    rows
}

/// The bars of one error.
fn column(
    svg: &mut String,
    rows: &[Row],
    bottom: f64,
    title: &str,
    (from, to): (f64, f64),
    of: fn(&Errors) -> f64,
) {
    let most = rows
        .iter()
        .flat_map(|row| [of(&row.fitted), of(&row.cross_validated)])
        .fold(1e-6, f64::max);
    let x = Scale::over((0.0, most), (from, to));
    let (levels, places) = ticks((0.0, most), nice_step(most, 4.0));
    let _ = write!(svg, "<text class=\"q\" x=\"{}\" y=\"14\">{title}</text>", Px(from));
    for level in levels {
        let at = x.at(level);
        let _ = write!(
            svg,
            "<path class=\"g\" d=\"M{at} {}V{}\"/><text class=\"tick\" x=\"{at}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            Px(TOP - 6.0),
            Px(bottom),
            Px(bottom + 16.0),
            number(level, places)
        );
    }
    for (k, row) in rows.iter().enumerate() {
        let class = if k == 0 { 'b' } else { 'a' };
        let (end, fitted) = (x.at(of(&row.cross_validated)), x.at(of(&row.fitted)));
        let _ = write!(
            svg,
            "<rect class=\"f{class}\" x=\"{x0}\" y=\"{y0}\" width=\"{w}\" height=\"{BAR}\" rx=\"3\"/>\
             <path class=\"body\" style=\"stroke:var(--ink)\" d=\"M{fitted} {y1}v26\"/>\
             <text class=\"v\" x=\"{tx}\" y=\"{ty}\" style=\"fill:var(--ink);font-size:14px\">{}</text>",
            number(of(&row.cross_validated), 1),
            x0 = Px(from),
            y0 = Px(row.y),
            w = Px((end.0 - from).max(1.5)),
            y1 = Px(row.y - 4.0),
            tx = Px(end.0.max(fitted.0) + 8.0),
            ty = Px(row.y + 14.0),
        );
    }
}
