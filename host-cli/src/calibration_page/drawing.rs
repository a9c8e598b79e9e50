//! The plan view of a calibration: both runs from above, x along the page, the lateral axis
//! exaggerated.

use std::fmt::Write;

use robot_model::kinematics::Pose;

use super::calibration_report::{CalibrationReport, RunReport};
use super::scale::{Px, Scale, nice_step, number, ticks};

/// Width of the drawing; all lengths here are in the SVG's own units.
const WIDTH: f64 = 960.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 138.0;
/// Room above a panel for its title, and between lateral range and panel edge.
const TITLE: f64 = 46.0;
/// Room below the panels for the ticks of the distance and two lines of words.
const FOOT: f64 = 90.0;
/// Tallest lateral range of one panel.
const PANEL_MOST: f64 = 190.0;

/// Colours for light and dark; before and after differ in lightness as well as in hue
/// (vermillion and blue of Okabe and Ito, made for every kind of colour vision).
pub(crate) const COLOURS: &str = "\
:root{--ink:#1b1f24;--soft:#5b6470;--faint:#d9dee4;--paper:#ffffff;--before:#c2410c;--after:#0369a1;--line:#8a94a0}\
@media (prefers-color-scheme:dark){:root{--ink:#e8ebef;--soft:#a3adb8;--faint:#333b45;--paper:#14181d;\
--before:#ff9a5c;--after:#5cc1f5;--line:#76818d}}\
@media print{:root{--ink:#000;--soft:#444;--faint:#ccc;--paper:#fff;--before:#c2410c;--after:#0369a1;--line:#777}}";

/// The style sheet of the drawing.
pub(crate) const STYLE: &str = "\
.d text{font:13px system-ui,-apple-system,'Segoe UI',Roboto,sans-serif;fill:var(--soft);font-variant-numeric:tabular-nums}\
.d .t{font-size:16px;font-weight:650;fill:var(--ink)}.d .v{font-size:17px;font-weight:650}\
.d .g{stroke:var(--faint);fill:none}.d .r{stroke:var(--line);stroke-dasharray:7 5;stroke-width:1.4;fill:none}\
.d .p{fill:none;stroke-width:2.8;stroke-linecap:round;stroke-linejoin:round}\
.d .b{stroke:var(--before)}.d .a{stroke:var(--after)}.d .fb{fill:var(--before)}.d .fa{fill:var(--after)}\
.d text.fb{fill:var(--before)}.d text.fa{fill:var(--after)}.d .o{opacity:.28}\
.d .body{fill:var(--paper);stroke-width:2}.d .w{stroke-width:4.6;stroke-linecap:round;fill:none}\
.d .n{stroke-width:2;fill:none;stroke-linecap:round;stroke-linejoin:round}.d .m{stroke-width:1.4;fill:none}\
.d{overflow:visible}";

/// One of the two runs; each has a letter in the style sheet.
#[derive(Clone, Copy)]
pub(super) enum Which {
    Before,
    After,
}

impl Which {
    const fn class(self) -> char {
        match self {
            Self::Before => 'b',
            Self::After => 'a',
        }
    }
}

/// The scales of the page, and the range that the runs cover.
struct Frame {
    distance_m: (f64, f64),
    lateral_m: (f64, f64),
    x: Scale,
    y_px_per_m: f64,
    exaggeration: f64,
    panel: f64,
}

impl Frame {
    fn of(report: &CalibrationReport) -> Self {
        let (mut distance_m, mut lateral_m) = ((0.0_f64, 0.05_f64), (-0.004_f64, 0.004_f64));
        let mut include = |x_m: f64, y_m: f64| {
            if x_m.is_finite() && y_m.is_finite() {
                distance_m = (distance_m.0.min(x_m), distance_m.1.max(x_m));
                lateral_m = (lateral_m.0.min(y_m), lateral_m.1.max(y_m));
            }
        };
        for run in [&report.before, &report.after] {
            run.path.iter().for_each(|pose| include(pose.x_m, pose.y_m));
            run.points_m.iter().for_each(|(x_m, y_m)| include(*x_m, *y_m));
            include(0.0, run.end.lateral_offset_m);
        }
        let x_px_per_m = (WIDTH - LEFT - RIGHT) / (distance_m.1 - distance_m.0);
        let span_m = lateral_m.1 - lateral_m.0;
        let most = PANEL_MOST / span_m / x_px_per_m;
        let exaggeration = [500.0, 200.0, 100.0, 50.0, 20.0, 10.0, 5.0, 2.0]
            .into_iter()
            .find(|nice| *nice <= most)
            .unwrap_or_else(|| most.min(1.0));
        let y_px_per_m = x_px_per_m * exaggeration;
        Self {
            distance_m,
            lateral_m,
            x: Scale::new(distance_m.0, LEFT, x_px_per_m),
            y_px_per_m,
            exaggeration,
            panel: span_m * y_px_per_m + 44.0,
        }
    }

    /// The lateral scale of a panel whose top lies at `top`: left of the line is up.
    fn y(&self, top: f64) -> Scale {
        Scale::new(self.lateral_m.1, top + 22.0, -self.y_px_per_m)
    }

    fn height(&self) -> f64 {
        2.0 * (TITLE + self.panel) + FOOT
    }
}

/// The drawing as an `svg` element; `head` goes in front of its content.
pub(super) fn plan_view(report: &CalibrationReport, attributes: &str, head: &str) -> String {
    let frame = Frame::of(report);
    let mut svg = format!(
        "<svg class=\"d\" viewBox=\"0 0 {} {}\"{attributes} role=\"img\" aria-label=\"Both runs from above\">{head}",
        Px(WIDTH),
        Px(frame.height())
    );
    let second = 2.0 * TITLE + frame.panel;
    panel(&mut svg, &frame, TITLE, &report.before, Which::Before);
    panel(&mut svg, &frame, second, &report.after, Which::After);
    distance_axis(&mut svg, &frame, second + frame.panel);
    svg.push_str("</svg>");
    svg
}

fn panel(svg: &mut String, frame: &Frame, top: f64, run: &RunReport, which: Which) {
    let class = which.class();
    let y = frame.y(top);
    let title = match which {
        Which::Before => "Before",
        Which::After => "After",
    };
    let (x0, x1) = (LEFT, WIDTH - RIGHT);
    // Writing to a String cannot fail.
    let _ = write!(
        svg,
        "<text class=\"t\" x=\"{}\" y=\"{}\">{title} <tspan class=\"f{class}\">W<tspan dy=\"3\" font-size=\".7em\">T</tspan><tspan dy=\"-3\"> = {}</tspan></tspan></text>",
        Px(x0),
        Px(top - 12.0),
        number(run.driven_with, 4)
    );
    let mm = (frame.lateral_m.0 * 1e3, frame.lateral_m.1 * 1e3);
    // A label takes 26 units of height.
    let most = ((frame.panel - 44.0) / 26.0).max(1.0);
    let (lateral, decimals) = ticks(mm, nice_step(mm.1 - mm.0, most));
    for tick_mm in lateral {
        let at = y.at(tick_mm / 1e3);
        if tick_mm != 0.0 {
            let _ = write!(svg, "<path class=\"g\" d=\"M{} {at}H{}\"/>", Px(x0), Px(x1));
        }
        let _ = write!(
            svg,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
            Px(x0 - 30.0),
            Px(at.0 + 4.5),
            number(tick_mm, decimals)
        );
    }
    let zero = y.at(0.0);
    let _ = write!(svg, "<path class=\"r\" d=\"M{} {zero}H{}\"/>", Px(x0), Px(x1 + 34.0));
    for (x_m, y_m) in thinned(&run.points_m) {
        let (x, y) = (frame.x.at(x_m), y.at(y_m));
        let _ = write!(svg, "<circle class=\"f{class} o\" cx=\"{x}\" cy=\"{y}\" r=\"1.7\"/>");
    }
    let _ = write!(svg, "<path class=\"p {class}\" d=\"{}\"/>", path_data(&run.path, &frame.x, &y));
    if let (Some(start), Some(end)) = (run.path.first(), run.path.last()) {
        robot(svg, frame, &y, *start, class, true);
        robot(svg, frame, &y, *end, class, false);
        deviation(svg, frame, &y, *end, run, class);
    }
}

/// The distance of the end from the line, as a dimension beside the path.
fn deviation(svg: &mut String, frame: &Frame, y: &Scale, end: Pose, run: &RunReport, class: char) {
    let (zero, at) = (y.at(0.0), y.at(end.y_m));
    let x = frame.x.at(end.x_m).0 + 28.0;
    if (at.0 - zero.0).abs() > 6.0 {
        let _ = write!(
            svg,
            "<path class=\"m {class}\" d=\"M{0} {zero}V{at}M{1} {at}h10M{1} {zero}h10\"/>",
            Px(x),
            Px(x - 5.0)
        );
    }
    let side = match run.end.lateral_offset_m {
        y if y < 0.0 => "to the right",
        _ => "to the left",
    };
    let middle = (zero.0 + at.0) / 2.0;
    let _ = write!(
        svg,
        "<text class=\"v f{class}\" x=\"{0}\" y=\"{1}\">{2} mm</text><text x=\"{0}\" y=\"{1}\" dy=\"1.25em\">{side}</text>",
        Px(x + 12.0),
        Px(middle - 1.0),
        number(run.end.lateral_offset_m.abs() * 1e3, 1)
    );
}

/// The robot from above, not to scale, turned as the drawn path is. Its x points along the path.
fn robot(svg: &mut String, frame: &Frame, y: &Scale, pose: Pose, class: char, start: bool) {
    let (sin, cos) = pose.heading_rad.sin_cos();
    let turn_deg = -(frame.exaggeration * sin).atan2(cos).to_degrees();
    let place = format!("{} {}", frame.x.at(pose.x_m), y.at(pose.y_m));
    let fade = if start { " opacity=\".55\"" } else { "" };
    let _ = write!(
        svg,
        "<g transform=\"translate({place}) rotate({})\"{fade}>\
         <path class=\"w {class}\" d=\"M-6 -14H6M-6 14H6\"/>\
         <rect class=\"body {class}\" x=\"-16\" y=\"-10\" width=\"28\" height=\"20\" rx=\"6\"/>\
         <circle class=\"f{class}\" cx=\"-10.5\" cy=\"0\" r=\"2.2\"/>\
         <path class=\"n {class}\" d=\"M2 -4.5L6.5 0L2 4.5\"/></g>",
        Px(turn_deg)
    );
}

fn distance_axis(svg: &mut String, frame: &Frame, top: f64) {
    let (along, decimals) =
        ticks(frame.distance_m, nice_step(frame.distance_m.1 - frame.distance_m.0, 8.0));
    for tick_m in along {
        let x = frame.x.at(tick_m);
        let _ = write!(
            svg,
            "<path class=\"g\" d=\"M{x} {}v6\"/><text x=\"{x}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            Px(top),
            Px(top + 22.0),
            number(tick_m, decimals)
        );
    }
    let exaggeration = match frame.exaggeration {
        nice if nice >= 2.0 => format!("lateral axis in mm, stretched \u{d7}{}", number(nice, 0)),
        _ => "lateral axis in mm".into(),
    };
    let _ = write!(
        svg,
        "<text x=\"{x}\" y=\"{}\">distance along the line in m</text>\
         <text x=\"{x}\" y=\"{}\">{exaggeration}; left is up; robot not to scale</text>",
        Px(top + 51.0),
        Px(top + 77.0),
        x = Px(LEFT)
    );
}

/// A path as SVG data; points closer than half a unit are left out, the last one never.
pub(super) fn path_data(path: &[Pose], x: &Scale, y: &Scale) -> String {
    let mut data = String::new();
    let mut drawn: Option<(f64, f64)> = None;
    for (i, pose) in path.iter().enumerate() {
        let (px, py) = (x.at(pose.x_m), y.at(pose.y_m));
        let near = drawn.is_some_and(|(dx, dy)| (px.0 - dx).hypot(py.0 - dy) < 0.5);
        if near && i + 1 < path.len() {
            continue;
        }
        let _ = write!(data, "{}{px} {py}", if drawn.is_some() { 'L' } else { 'M' });
        drawn = Some((px.0, py.0));
    }
    data
}

/// At most 240 points, evenly spaced, so that a long recording does not make a large file.
fn thinned(points: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> {
    points.iter().step_by(points.len().div_ceil(240).max(1)).copied()
}
