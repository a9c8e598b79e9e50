//! A small drawing of curves over time.

use std::fmt::Write;

use crate::calibration_page::scale::{Px, Scale, bounds, grid_rows, numbers_below};
use crate::escape::html as escape;

const X: (f64, f64) = (54.0, 452.0);
const Y: (f64, f64) = (168.0, 24.0);
/// A curve needs no more points than this to be seen.
const POINTS: usize = 1000;

/// A curve: its class in the style sheet, and time and value of each point.
pub(super) struct Curve {
    pub class: &'static str,
    pub points: Vec<[f64; 2]>,
}

/// A figure with a title, what is said beside it, the unit of its values, and its curves.
pub(super) fn figure(html: &mut String, title: &str, caption: &str, unit: &str, curves: &[Curve]) {
    let all = || curves.iter().flat_map(|curve| &curve.points);
    let ([from, low], [to, high]) = bounds(all());
    let (low, high) = (low.min(0.0), high.max(0.0));
    let room = 0.06 * (high - low).max(1e-6);
    let (span, range) = ((from, to.max(from + 1e-6)), (low - room, high + room));
    let (x, y) = (Scale::over(span, X), Scale::over(range, Y));
    let _ = write!(
        html,
        "<figure><figcaption><b>{}</b><span>{}</span></figcaption>\
         <svg class=\"d thin\" viewBox=\"0 0 460 194\" role=\"img\" aria-label=\"{}, {}\">\
         <text class=\"tick\" x=\"{}\" y=\"10\">{unit}</text>",
        escape(title),
        escape(caption),
        escape(title),
        escape(caption),
        Px(X.0)
    );
    grid_rows(html, &y, range, X);
    numbers_below(html, &x, span, 186, " s");
    for Curve { class, points } in curves {
        let every = points.len().div_ceil(POINTS).max(1);
        let last = points.len().saturating_sub(1);
        let mut data = String::new();
        let drawn = points.iter().enumerate().filter(|(i, _)| i % every == 0 || *i == last);
        for (_, [t_s, value]) in drawn {
            let step = if data.is_empty() { 'M' } else { 'L' };
            let _ = write!(data, "{step}{} {}", x.at(*t_s), y.at(*value));
        }
        let _ = write!(html, "<path class=\"{class}\" d=\"{data}\"/>");
    }
    html.push_str("</svg></figure>\n");
}
