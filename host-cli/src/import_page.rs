//! What an import understood, on one page: speeds of wheels and poses on one clock, the path, the cuts.
//!
//! A mistake of the import is to be seen: both speeds lie on each other, and the coloured stretches are the runs.

use std::fmt::Write;

use import::alignment::Speeds;
use import::understand::Understood;
use robot_model::recording::Recording;

use crate::calibration_page::drawing::{COLOURS, STYLE};
use crate::calibration_page::page::PAGE_STYLE;
use crate::calibration_page::scale::{Px, Scale, bounds, nice_step, number, ticks};
use crate::escape::html as escape;

/// Width and height of a drawing over time, in its own units, and its margins.
const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 200.0;
const LEFT: f64 = 56.0;
const BOTTOM: f64 = 26.0;
/// So many points of a line at most: one a unit.
const POINTS: usize = 900;
/// Height of the path, and of one in a row of paths.
const PATH: f64 = 420.0;

/// The page.
pub fn page(understood: &Understood, names: &[String]) -> String {
    let name = escape(&understood.robot.name);
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">{}\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <title>{name}: import</title>\n<style>{COLOURS}\n{STYLE}\n{PAGE_STYLE}\
         .d .run{{fill:var(--after);opacity:.12}}.d .thin{{fill:none;stroke-width:1.3}}</style></head>\n<body>\n\
         <p class=\"sub\">{name}</p>\n<h1>{} understood</h1>\n<p>{}.</p>\n",
        of_runs(names),
        escape(&crate::ui::runs(names.len())),
        escape(&clock(understood))
    );
    if !understood.notes.is_empty() {
        html.push_str("<ul>\n");
        for note in &understood.notes {
            let _ = writeln!(html, "<li>{}</li>", escape(&note.text));
        }
        html.push_str("</ul>\n");
    }
    if let Some((speeds, alignment)) = &understood.speeds {
        let scales = [alignment.travel_per_unit, alignment.turn_per_unit];
        for (axis, what) in [(0, "Speed, m/s"), (1, "Turn rate, rad/s")] {
            let Some(scale) = scales[axis] else { continue };
            let _ = writeln!(
                html,
                "<h2>{what}: by the <span class=\"before\">wheels</span>, by the <span class=\"after\">poses</span>, runs shaded</h2>"
            );
            over_time(&mut html, understood, speeds, (axis, scale));
        }
    }
    html.push_str("<h2>The path, as measured</h2>\n");
    path(&mut html, understood, names);
    html.push_str("<h2>The runs</h2>\n");
    table(&mut html, understood, names);
    html.push_str("</body></html>\n");
    html
}

/// By which it is known of which runs a page is.
pub fn of_runs(names: &[String]) -> String {
    format!("<meta name=\"beeline-runs\" content=\"{}\">", escape(&names.join(" ")))
}

/// How the clocks go together, in words.
pub fn clock(understood: &Understood) -> String {
    let clock = &understood.clock;
    let apart = match clock.late_s {
        0.0 => return "wheels and poses are on one clock".into(),
        late_s if late_s > 0.0 => format!("the poses are {late_s:.3} s late"),
        late_s => format!("the poses are {:.3} s early", -late_s),
    };
    let sigma = if clock.sigma_s > 0.0 {
        format!(" (± {:.1} ms)", clock.sigma_s * 1e3)
    } else {
        String::new()
    };
    let by_run = if clock.differs_by_run { ", and runs differ" } else { "" };
    let drift = match clock.rate() {
        0.0 => String::new(),
        drift if drift > 0.0 => format!(", and their clock runs {:.0} ppm fast", drift * 1e6),
        drift => format!(", and their clock runs {:.0} ppm slow", -drift * 1e6),
    };
    format!("{apart}{sigma}{drift}{by_run}: corrected")
}

/// Both speeds over the time of the log.
fn over_time(
    html: &mut String,
    understood: &Understood,
    speeds: &[Speeds; 2],
    (axis, scale): (usize, f64),
) {
    let begin_s = speeds[0].start_s.min(speeds[1].start_s);
    let end = |speeds: &Speeds| speeds.start_s + speeds.values.len() as f64 * speeds.step_s;
    let end_s = end(&speeds[0]).max(end(&speeds[1]));
    let lines = [
        points(&speeds[0], speeds[0].start_s - begin_s, axis, scale),
        points(&speeds[1], speeds[1].start_s - begin_s, axis, 1.0),
    ];
    let most = lines
        .iter()
        .flatten()
        .map(|point| point[1])
        .filter(|value| value.is_finite())
        .fold(1e-6, f64::max);
    let x = Scale::over((0.0, (end_s - begin_s).max(1e-6)), (LEFT, WIDTH - 4.0));
    let y = Scale::over((0.0, most * 1.05), (HEIGHT - BOTTOM, 6.0));
    let _ = write!(html, "<svg class=\"d\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\">");
    for run in &understood.runs {
        let from_s = run.started_s - begin_s;
        let (a, b) = (x.at(from_s), x.at(from_s + run.recording.duration_s()));
        let _ = write!(
            html,
            "<rect class=\"run\" x=\"{a}\" y=\"6\" width=\"{}\" height=\"{}\"/>",
            Px(b.0 - a.0),
            Px(HEIGHT - BOTTOM - 6.0)
        );
    }
    let (levels, places) = ticks((0.0, most), nice_step(most, 4.0));
    for level in levels {
        let at = y.at(level);
        let _ = write!(
            html,
            "<path class=\"g\" d=\"M{LEFT} {at}H{WIDTH}\"/><text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
            Px(LEFT - 8.0),
            Px(at.0 + 4.5),
            number(level, places)
        );
    }
    let span_s = end_s - begin_s;
    let (times, places) = ticks((0.0, span_s), nice_step(span_s, 8.0));
    for time_s in times {
        let _ = write!(
            html,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{} s</text>",
            x.at(time_s),
            Px(HEIGHT - 8.0),
            number(time_s, places)
        );
    }
    for (points, class) in lines.iter().zip(["b", "a"]) {
        let _ = write!(html, "<path class=\"thin {class}\" d=\"{}\"/>", line(points, &x, &y));
    }
    html.push_str("</svg>\n");
}

/// Means of a line over as many stretches as can be drawn.
fn points(speeds: &Speeds, start_s: f64, axis: usize, scale: f64) -> Vec<[f64; 2]> {
    let by = speeds.values.len().div_ceil(POINTS).max(1);
    speeds
        .values
        .chunks(by)
        .enumerate()
        .map(|(k, values)| {
            let known =
                values.iter().map(|value| f64::from(value[axis])).filter(|value| !value.is_nan());
            let (sum, count) =
                known.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
            [start_s + ((k * by) as f64 + by as f64 / 2.0) * speeds.step_s, scale * sum / count]
        })
        .collect()
}

/// A line; it is interrupted where a point is unknown.
fn line(points: &[[f64; 2]], x: &Scale, y: &Scale) -> String {
    let mut data = String::new();
    let mut pen = 'M';
    for [a, b] in points {
        if a.is_finite() && b.is_finite() {
            let _ = write!(data, "{pen}{} {}", x.at(*a), y.at(*b));
            pen = 'L';
        } else {
            pen = 'M';
        }
    }
    data
}

/// The measured positions of a run, as many as can be drawn.
fn positions(recording: &Recording) -> Vec<[f64; 2]> {
    let by = recording.measured_poses.len().div_ceil(POINTS).max(1);
    recording.measured_poses.iter().step_by(by).filter_map(|pose| pose.position_m).collect()
}

fn path(html: &mut String, understood: &Understood, names: &[String]) {
    let paths: Vec<Vec<[f64; 2]>> =
        understood.runs.iter().map(|run| positions(&run.recording)).collect();
    let (low, high) = bounds(paths.iter().flatten());
    let size_m = (high[0] - low[0]).max(1e-3).max((high[1] - low[1]).max(1e-3) * WIDTH / PATH);
    let per_m = (WIDTH - 40.0) / size_m;
    let (x, y) = (Scale::new(low[0], 20.0, per_m), Scale::new(high[1], 20.0, -per_m));
    let height = Px((high[1] - low[1]) * per_m + 60.0);
    let _ = write!(html, "<svg class=\"d\" viewBox=\"0 0 {WIDTH} {height}\" role=\"img\">");
    for (points, name) in paths.iter().zip(names) {
        let _ = write!(
            html,
            "<path class=\"thin a\" d=\"{}\"><title>{}</title></path>",
            line(points, &x, &y),
            escape(name)
        );
    }
    let bar_m = nice_step(size_m, 6.0);
    let (from, to) = (Px(20.0), Px(20.0 + bar_m * per_m));
    let at = Px(height.0 - 10.0);
    let _ = writeln!(
        html,
        "<path class=\"r\" d=\"M{from} {at}H{to}\"/><text x=\"{}\" y=\"{}\">{} m</text></svg>",
        Px(to.0 + 8.0),
        Px(at.0 + 4.0),
        bar_m
    );
}

fn table(html: &mut String, understood: &Understood, names: &[String]) {
    html.push_str("<table><thead><tr><th>run</th><th>began, s</th><th>took, s</th><th>poses</th><th>begins</th></tr></thead>\n<tbody>");
    let begin_s = understood.begin_s();
    for (run, name) in understood.runs.iter().zip(names) {
        let _ = writeln!(
            html,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            escape(name),
            number(run.started_s - begin_s, 1),
            number(run.recording.duration_s(), 1),
            run.recording.measured_poses.len(),
            run.begins.words()
        );
    }
    for left in &understood.left_out {
        let _ = writeln!(
            html,
            "<tr><td>left out</td><td>{}</td><td>{}</td><td></td><td>{}</td></tr>",
            number(left.from_s - begin_s, 1),
            number(left.to_s - left.from_s, 1),
            escape(&left.why)
        );
    }
    html.push_str("</tbody></table>\n");
}
