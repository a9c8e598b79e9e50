//! The story of a campaign as one drawing that stands alone: the error falls, and three runs from above.

use std::fmt::Write;

use super::{CampaignReport, DRAWING_STYLE, paths, title, waterfall};
use crate::calibration_page::drawing::{COLOURS, STYLE};
use crate::calibration_page::scale::Px;
use crate::escape::html as escape;

const MARGIN: f64 = 32.0;
const PANELS: usize = 3;
const GAP: f64 = 30.0;

/// The drawing as a stand-alone SVG file; it follows the dark mode.
pub fn to_svg(report: &CampaignReport<'_>) -> String {
    let (fall_height, fall) = waterfall::drawing(report);
    let panels = paths::worst(report, PANELS);
    let width = waterfall::WIDTH + 2.0 * MARGIN;
    let (fall_y, panels_y) = (84.0, 84.0 + fall_height + 34.0);
    let panels_height = if panels.is_empty() { 0.0 } else { paths::HEIGHT + 40.0 };
    let height = panels_y + panels_height;
    let name = escape(report.context.robot);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" class=\"d\">\
         <title>{name}</title><style>{COLOURS}{STYLE}{DRAWING_STYLE}</style>\
         <rect width=\"100%\" height=\"100%\" rx=\"12\" style=\"fill:var(--paper)\"/>\
         <text class=\"t\" x=\"{MARGIN}\" y=\"40\">{}</text>\
         <text x=\"{MARGIN}\" y=\"62\">{name}, {}: each predicted by a fit to all others</text>\
         <g transform=\"translate({MARGIN} {fall_y})\">{fall}</g>",
        escape(&title(report.answer)),
        crate::ui::runs(report.context.runs.len()),
        w = Px(width),
        h = Px(height)
    );
    for (k, (run, lines)) in panels.iter().enumerate() {
        let x = MARGIN + (paths::WIDTH + GAP) * k as f64;
        let _ = write!(
            svg,
            "<text class=\"q\" x=\"{x}\" y=\"{y}\">{run}</text><g class=\"thin\" transform=\"translate({x} {top})\">{lines}</g>",
            x = Px(x),
            y = Px(panels_y),
            top = Px(panels_y + 8.0)
        );
    }
    if !panels.is_empty() {
        let _ = write!(
            svg,
            "<text class=\"tick\" x=\"{MARGIN}\" y=\"{}\">grey: measured \u{2003} orange: the {before} \u{2003} \
             blue: with the missing effects \u{2003} (deviations enlarged by the factor in the corner)</text>",
            Px(height - 12.0),
            before = super::before(report.answer)
        );
    }
    svg.push_str("</svg>\n");
    svg
}
