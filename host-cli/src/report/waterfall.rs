//! The cross-validated error as one effect after the other is added.

use std::fmt::Write;

use findings::words;
use robot_model::estimation::Errors;

use super::campaign_report::{CampaignReport, before};
use crate::calibration_page::scale::{Px, Scale, grid_columns, nice_step, number, ticks};
use crate::escape::html as escape;
use crate::quantity::p_value;
use crate::table::wrapped;

/// Width of the drawing on a wide page.
pub(super) const WIDTH: f64 = WIDE.width;

/// Where things are on a page.
struct Layout {
    width: f64,
    /// Where the columns of bars begin and end.
    position: (f64, f64),
    heading: (f64, f64),
    /// So many letters fit in a line of a name.
    letters: usize,
    /// Whether names stand above their bars, and not at the left of them.
    names_above: bool,
}

const WIDE: Layout = Layout {
    width: 960.0,
    position: (300.0, 590.0),
    heading: (680.0, 900.0),
    letters: 40,
    names_above: false,
};

/// For a telephone: no wider than its screen, so that letters keep their size.
const NARROW: Layout = Layout {
    width: 350.0,
    position: (5.0, 130.0),
    heading: (184.0, 294.0),
    letters: 46,
    names_above: true,
};

/// Where the rows begin; the height of a bar, and of a line of text.
const TOP: f64 = 30.0;
const BAR: f64 = 18.0;
const LINE: f64 = 15.0;
/// A name has at most so many lines.
const LINES: usize = 3;

/// A model: its name in lines, how likely by chance, its errors, and where it is drawn.
struct Row {
    name: Vec<String>,
    p: String,
    fitted: Errors,
    cross_validated: Errors,
    y: f64,
    bar_y: f64,
}

impl Row {
    fn new(y: f64, name: Vec<String>, p: String, errors: [Errors; 2], layout: &Layout) -> Self {
        let [fitted, cross_validated] = errors;
        let row = Self { name, p, fitted, cross_validated, y, bar_y: y };
        let bar_y = if layout.names_above { y + row.words() + 6.0 } else { y };
        Self { bar_y, ..row }
    }

    /// The height of its words.
    fn words(&self) -> f64 {
        let lines = self.name.len() + usize::from(!self.p.is_empty());
        lines as f64 * LINE
    }

    /// Where the next row begins.
    fn end(&self) -> f64 {
        (self.y + self.words()).max(self.bar_y + BAR) + 10.0
    }
}

pub(super) fn draw(report: &CampaignReport<'_>) -> String {
    [("only-wide", &WIDE), ("only-narrow", &NARROW)]
        .map(|(class, layout)| {
            let (height, lines) = drawing_as(report, layout);
            format!(
                "<svg class=\"d {class}\" viewBox=\"0 0 {} {}\" role=\"img\" \
                 aria-label=\"Error as effects are added\">{lines}</svg>\n",
                Px(layout.width),
                Px(height)
            )
        })
        .concat()
}

/// The height of the wide drawing, and its lines.
pub(super) fn drawing(report: &CampaignReport<'_>) -> (f64, String) {
    drawing_as(report, &WIDE)
}

fn drawing_as(report: &CampaignReport<'_>, layout: &Layout) -> (f64, String) {
    let rows = rows(report, layout);
    let bottom = rows.last().map_or(TOP, Row::end);
    let mut svg = String::new();
    let position = |errors: &Errors| errors.position_rms_m * 1e3;
    let heading = |errors: &Errors| errors.heading_rms_rad * 1e3;
    column(&mut svg, &rows, bottom, "position, mm", layout.position, position);
    // Where only positions are measured, nothing is known of headings.
    if report.answer.baseline.cross_validated.heading_rms_rad > 0.0 {
        column(&mut svg, &rows, bottom, "heading, mrad", layout.heading, heading);
    }
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

fn rows(report: &CampaignReport<'_>, layout: &Layout) -> Vec<Row> {
    let answer = report.answer;
    let first = vec![before(answer).into()];
    let baseline = [answer.baseline.fitted, answer.baseline.cross_validated];
    let mut rows = vec![Row::new(TOP, first, String::new(), baseline, layout)];
    for step in &answer.steps {
        let names: Vec<&str> = step.class.iter().map(|id| report.context.name(id)).collect();
        let mut name = wrapped(&format!("+ {}", names.join(" or ")), layout.letters);
        if name.len() > LINES {
            name.truncate(LINES);
            name[LINES - 1].push_str(" \u{2026}");
        }
        let p = p_value(step.p_value).replace('<', "&lt;");
        let y = rows.last().map_or(TOP, Row::end);
        rows.push(Row::new(y, name, p, [step.fitted, step.cross_validated], layout));
    }
    let y = rows.last().map_or(TOP, Row::end);
    let reachable = vec![words::error_floor(&answer.unexplained).into()];
    rows.push(Row::new(y, reachable, String::new(), [answer.reachable; 2], layout));
    rows
}

/// The bars of one error.
fn column(
    svg: &mut String,
    rows: &[Row],
    bottom: f64,
    title: &str,
    (from, to): (f64, f64),
    of: impl Fn(&Errors) -> f64,
) {
    let most = rows
        .iter()
        .flat_map(|row| [of(&row.fitted), of(&row.cross_validated)])
        .fold(1e-6, f64::max);
    let x = Scale::over((0.0, most), (from, to));
    let _ = write!(svg, "<text class=\"q\" x=\"{}\" y=\"14\">{title}</text>", Px(from));
    let columns = ticks((0.0, most), nice_step(most, 4.0));
    grid_columns(svg, &x, columns, (TOP - 6.0, bottom), bottom + 16.0);
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
            y0 = Px(row.bar_y),
            w = Px((end.0 - from).max(1.5)),
            y1 = Px(row.bar_y - 4.0),
            tx = Px(end.0.max(fitted.0) + 8.0),
            ty = Px(row.bar_y + 14.0),
        );
    }
}
