//! The values of one parameter over time, or robot by robot where there is only one date.

use std::fmt::Write;

use findings::quantity::scaled_unit;
use robot_model::explain::ParameterFound;
use robot_model::fleet::RobotJudged;

use super::{FleetParameter, Kind, Studied, places};
use crate::calibration_page::scale::{Px, Scale, grid_rows};
use crate::escape::html as escape;

const WIDTH: f64 = 460.0;
const X: (f64, f64) = (54.0, 360.0);
const Y: (f64, f64) = (188.0, 14.0);
/// Robots that nothing is said of are background: more of them are thinned out.
const BACKGROUND_MAX: usize = 150;
/// Fewer robots have no place where most of them are.
pub(super) const BAND_ROBOTS_MIN: usize = 3;

/// A value with its place in a drawing.
struct Dot {
    at: f64,
    value: f64,
    low: f64,
    high: f64,
}

/// One robot's values.
struct Line<'a> {
    name: &'a str,
    class: &'static str,
    dots: Vec<Dot>,
}

/// One parameter of a kind; empty if it has no value.
pub(super) fn draw(kind: &Kind, parameter: &FleetParameter) -> String {
    let size = |found: &ParameterFound| found.value.abs().max(found.sigma);
    let most = parameter.values.iter().flatten().map(size).fold(0.0, f64::max);
    if most == 0.0 {
        return String::new();
    }
    let (factor, unit) = scaled_unit(most, &parameter.unit);
    let over_time = parameter.judgement.robots.iter().any(|robot| robot.trend.is_some());
    let lines = lines(kind, parameter, factor, over_time);
    let dots = || lines.iter().flat_map(|line| &line.dots);
    let ends = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)))
    };
    let span = padded(ends(&mut dots().map(|dot| dot.at)), 0.5);
    let range = ends(&mut dots().flat_map(|dot| [dot.low, dot.high]).chain([0.0]));
    let range = padded(range, 1e-6);
    let (x, y) = (Scale::over(span, X), Scale::over(range, Y));
    let facts = parameter.effect.facts();
    let mut svg = format!(
        "<figure><figcaption><b>{}</b><span>{} {}{}</span></figcaption>\
         <svg class=\"d thin\" viewBox=\"0 0 {WIDTH} 214\" role=\"img\" aria-label=\"{}\">",
        escape(facts.name),
        escape(facts.id),
        escape(&parameter.name),
        if unit.is_empty() { String::new() } else { format!(", {}", escape(&unit)) },
        escape(facts.name)
    );
    band(&mut svg, parameter, factor, &y, range);
    axes(&mut svg, (&x, span), (&y, range), over_time);
    for line in &lines {
        robot(&mut svg, line, (&x, &y));
    }
    names(&mut svg, &lines, &y);
    svg.push_str("</svg></figure>");
    svg
}

/// A range with room at both ends.
fn padded((low, high): (f64, f64), least: f64) -> (f64, f64) {
    let room = (0.05 * (high - low)).max(least);
    (low - room, high + room)
}

/// What is drawn, the background first.
fn lines<'a>(
    kind: &'a Kind,
    parameter: &FleetParameter,
    factor: f64,
    over_time: bool,
) -> Vec<Line<'a>> {
    let robots = &parameter.judgement.robots;
    let class = |robot: &RobotJudged| match robot.trend {
        Some(trend) if trend.is_there => "b",
        _ if robot.is_unlike => "a",
        _ => "n0",
    };
    let quiet = robots.iter().filter(|robot| class(robot) == "n0").count();
    let every = quiet.div_ceil(BACKGROUND_MAX).max(1);
    let mut lines: Vec<Line<'_>> = Vec::new();
    for (place, robot) in robots.iter().enumerate() {
        let class = class(robot);
        if class == "n0" && place % every != 0 {
            continue;
        }
        let own = kind.campaigns.iter().zip(&parameter.values);
        let dot = |(one, found): (&Studied, &Option<ParameterFound>)| {
            let found = found.as_ref().filter(|_| one.robot == robot.robot)?;
            let at = if over_time { one.dated.days? } else { place as f64 };
            let [value, low, high] = [found.value, found.low95, found.high95].map(|v| v * factor);
            Some(Dot { at, value, low, high })
        };
        lines.push(Line {
            name: &kind.robots[robot.robot],
            class,
            dots: own.filter_map(dot).collect(),
        });
    }
    lines.sort_by_key(|line| line.class != "n0");
    lines
}

/// Where most robots of the kind are: the mean, and twice what they differ by.
fn band(svg: &mut String, parameter: &FleetParameter, factor: f64, y: &Scale, range: (f64, f64)) {
    let judgement = &parameter.judgement;
    if judgement.robots.len() < BAND_ROBOTS_MIN {
        return;
    }
    let half = 2.0 * judgement.spread * factor;
    let mean = judgement.mean * factor;
    let (low, high) = ((mean - half).max(range.0), (mean + half).min(range.1));
    let (top, bottom) = (y.at(high).0, y.at(low).0);
    let _ = write!(
        svg,
        "<rect class=\"noise\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>",
        Px(X.0),
        Px(top),
        Px(X.1 - X.0),
        Px((bottom - top).max(1.0))
    );
}

fn axes(
    svg: &mut String,
    (x, span): (&Scale, (f64, f64)),
    (y, range): (&Scale, (f64, f64)),
    over_time: bool,
) {
    grid_rows(svg, y, range, X);
    if !over_time {
        let _ = write!(
            svg,
            "<text class=\"tick\" x=\"{}\" y=\"208\" text-anchor=\"middle\">robots</text>",
            Px((X.0 + X.1) / 2.0)
        );
        return;
    }
    for days in [span.0.ceil(), ((span.0 + span.1) / 2.0).round(), span.1.floor()] {
        let _ = write!(
            svg,
            "<text class=\"tick\" x=\"{}\" y=\"208\" text-anchor=\"middle\">{}</text>",
            x.at(days),
            places::date(days)
        );
    }
}

fn robot(svg: &mut String, line: &Line<'_>, (x, y): (&Scale, &Scale)) {
    let _ = write!(svg, "<g class=\"{}\"><title>{}</title>", line.class, escape(line.name));
    let mut path = String::new();
    for dot in &line.dots {
        let letter = if path.is_empty() { 'M' } else { 'L' };
        let _ = write!(path, "{letter}{} {}", x.at(dot.at), y.at(dot.value));
    }
    if line.dots.len() > 1 {
        let _ = write!(svg, "<path class=\"p {}\" d=\"{path}\"/>", line.class);
    }
    for dot in &line.dots {
        let cx = x.at(dot.at);
        let _ = write!(
            svg,
            "<path class=\"whisker {0}\" d=\"M{cx} {1}V{2}\"/><circle class=\"f{0}\" cx=\"{cx}\" cy=\"{3}\" r=\"3\"/>",
            line.class,
            y.at(dot.low),
            y.at(dot.high),
            y.at(dot.value)
        );
    }
    svg.push_str("</g>");
}

/// Names of the robots that something is said of, beside their last value and clear of each other.
fn names(svg: &mut String, lines: &[Line<'_>], y: &Scale) {
    let named = lines.iter().filter(|line| line.class != "n0");
    let mut places: Vec<(f64, &Line<'_>)> =
        named.filter_map(|line| Some((y.at(line.dots.last()?.value).0, line))).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut above = f64::NEG_INFINITY;
    for (at, line) in places {
        let at = at.max(above + 15.0);
        above = at;
        let short: String = line.name.chars().take(14).collect();
        let _ = write!(
            svg,
            "<text class=\"f{}\" x=\"{}\" y=\"{}\">{}</text>",
            line.class,
            Px(X.1 + 8.0),
            Px(at + 4.0),
            escape(&short)
        );
    }
}
