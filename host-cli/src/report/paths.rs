//! Measured and predicted paths from above: small drawings, the worst runs of each kind.

use std::fmt::Write;

use robot_model::compare::Path;
use robot_model::recording::RunKind;

use super::campaign_report::{CampaignReport, before, legend};
use crate::calibration_page::scale::{Px, bounds, nice_step, number};
use crate::escape::html as escape;

/// So many drawings at most.
const PANELS: usize = 9;
/// Size of a drawing, in its own units.
pub(super) const WIDTH: f64 = 300.0;
pub(super) const HEIGHT: f64 = 230.0;
const PAD: f64 = 16.0;
/// A turn on the spot leaves no path to be seen \[m\].
const SIZE_MIN_M: f64 = 0.1;

pub(super) fn draw(report: &CampaignReport<'_>) -> String {
    let mut html = String::new();
    legend(&mut html, before(report.answer), true);
    html.push_str("<div class=\"grid\">");
    for index in chosen(report.paths[0], &report.answer.unexplained.runs_off) {
        panel(&mut html, &report.paths[0][index], &report.paths[1][index]);
    }
    html.push_str("</div>\n");
    html
}

/// Root of the mean squared distance \[m\].
fn rms_m(path: &Path) -> f64 {
    let squares =
        path.measured_m.iter().zip(&path.predicted_m).map(|(a, b)| distance(*a, *b).powi(2));
    let squares = squares.filter(|square: &f64| square.is_finite());
    (squares.sum::<f64>() / path.measured_m.len().max(1) as f64).sqrt()
}

/// Greater side of the box round a path \[m\].
fn size_m(path: &Path) -> f64 {
    let (low, high) = bounds(path.shape_m().iter());
    if path.measured_m.len() < 2 { 0.0 } else { (high[0] - low[0]).max(high[1] - low[1]) }
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// The runs that are off by far more than the others, then the worst of each kind in turn; in the order of the campaign.
fn chosen(paths: &[Path], off: &[String]) -> Vec<usize> {
    let mut by_kind: Vec<(RunKind, Vec<usize>)> = Vec::new();
    let mut all: Vec<usize> =
        (0..paths.len()).filter(|i| size_m(&paths[*i]) > SIZE_MIN_M).collect();
    all.sort_by(|a, b| rms_m(&paths[*b]).total_cmp(&rms_m(&paths[*a])));
    for index in all {
        let kind = paths[index].kind;
        match by_kind.iter_mut().find(|(name, _)| *name == kind) {
            Some((_, of_kind)) => of_kind.push(index),
            None => by_kind.push((kind, vec![index])),
        }
    }
    let most = by_kind.iter().map(|(_, of_kind)| of_kind.len()).max().unwrap_or(0);
    let turns =
        (0..most).flat_map(|turn| by_kind.iter().filter_map(move |(_, of_kind)| of_kind.get(turn)));
    let (mut chosen, others): (Vec<usize>, Vec<usize>) =
        turns.copied().partition(|index| off.contains(&paths[*index].run));
    chosen.extend(others);
    chosen.truncate(PANELS);
    chosen.sort_unstable();
    chosen
}

fn panel(html: &mut String, nominal: &Path, model: &Path) {
    let name = escape(&nominal.run);
    let held_out = if nominal.held_out { ", held out" } else { "" };
    let _ = write!(
        html,
        "<figure><figcaption><b>{name}{held_out}</b><span>{}</span></figcaption>\
         <svg class=\"d thin\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"Path of {name}\">{}</svg></figure>",
        errors(nominal, model),
        Px(WIDTH),
        Px(HEIGHT),
        drawing(nominal, model)
    );
}

/// The largest few runs of a drawing that stands alone, side by side: each `WIDTH` x `HEIGHT`.
pub(super) fn worst(report: &CampaignReport<'_>, most: usize) -> Vec<(String, String)> {
    let mut indices = chosen(report.paths[0], &report.answer.unexplained.runs_off);
    let off = |i: &usize| rms_m(&report.paths[0][*i]);
    indices.sort_by(|a, b| off(b).total_cmp(&off(a)));
    let mut kinds = Vec::new();
    indices.retain(|index| {
        let kind = report.paths[0][*index].kind;
        let new = !kinds.contains(&kind);
        kinds.push(kind);
        new
    });
    let pair = |i: usize| (&report.paths[0][i], &report.paths[1][i]);
    let panels = indices.into_iter().take(most).map(pair);
    panels.map(|(nominal, model)| (escape(&nominal.run), drawing(nominal, model))).collect()
}

/// `20.5 -> 1.4 mm`, in the two colours.
fn errors(nominal: &Path, model: &Path) -> String {
    format!(
        "<span class=\"before\">{}</span> \u{2192} <span class=\"after\">{} mm</span>",
        number(rms_m(nominal) * 1e3, 1),
        number(rms_m(model) * 1e3, 1)
    )
}

/// How far off the prediction is along the run \[m\], each the mean over a twentieth of the run: it is
/// the shape that is to be seen, not the noise of single samples, which would be enlarged with it.
fn deviations_m(path: &Path) -> Vec<[f64; 2]> {
    let off: Vec<[f64; 2]> = path
        .measured_m
        .iter()
        .zip(&path.predicted_m)
        .map(|(a, b)| [b[0] - a[0], b[1] - a[1]])
        .collect();
    let reach = off.len() / 40;
    let mean = |at: usize| {
        // As far to both sides: at its ends a run is not drawn towards its middle.
        let reach = reach.min(at).min(off.len() - 1 - at);
        let near = &off[at - reach..=at + reach];
        let finite: Vec<_> =
            near.iter().filter(|off| off.iter().all(|part| part.is_finite())).collect();
        [0, 1].map(|axis| finite.iter().map(|off| off[axis]).sum::<f64>() / finite.len() as f64)
    };
    (0..off.len()).map(mean).collect()
}

/// The lines of one drawing.
fn drawing(nominal: &Path, model: &Path) -> String {
    if !nominal.way_m.is_empty() {
        return drawing_of_ends(nominal, model);
    }
    let [off_nominal, off_model] = [deviations_m(nominal), deviations_m(model)];
    let off_m = off_nominal.iter().map(|off| off[0].hypot(off[1])).fold(0.0, f64::max);
    let (low, high) = bounds(nominal.measured_m.iter());
    let size_m = (high[0] - low[0]).max(high[1] - low[1]).max(0.02);
    // The largest deviation is to be a seventh of the drawing.
    let wanted = 0.14 * size_m / off_m.max(1e-9);
    let factor = [10.0, 5.0, 2.0].into_iter().find(|factor| *factor <= wanted).unwrap_or(1.0);
    let enlarged = |path: &Path, off: &[[f64; 2]]| -> Vec<[f64; 2]> {
        let both = path.measured_m.iter().zip(off);
        both.map(|(a, off)| [a[0] + factor * off[0], a[1] + factor * off[1]]).collect()
    };
    let (before, after) = (enlarged(nominal, &off_nominal), enlarged(model, &off_model));
    let view = View::of(nominal.measured_m.iter().chain(&before).chain(&after));
    format!(
        "<path class=\"seen\" d=\"{}\"/><path class=\"p b\" d=\"{}\"/><path class=\"p a\" d=\"{}\"/>{}\
         <text class=\"tick\" x=\"{}\" y=\"{}\" text-anchor=\"end\">\u{d7}{}</text>",
        view.line(&nominal.measured_m),
        view.line(&before),
        view.line(&after),
        view.bar(),
        Px(WIDTH - 4.0),
        Px(HEIGHT - 6.0),
        number(factor, 0),
    )
}

/// The same where poses were measured only at the ends: dead reckoning to scale, and dots for the poses.
fn drawing_of_ends(nominal: &Path, model: &Path) -> String {
    let points = nominal.measured_m.iter().chain(&nominal.way_m).chain(&model.way_m);
    let view = View::of(points);
    let mut dots = String::new();
    for point in nominal.measured_m.iter().filter(|point| point.iter().all(|part| part.is_finite()))
    {
        let (x, y) = view.at(point);
        let _ = write!(
            dots,
            "<circle class=\"dot\" style=\"fill:var(--line)\" fill-opacity=\".75\" cx=\"{x}\" cy=\"{y}\" r=\"5\"/>"
        );
    }
    format!(
        "{dots}<path class=\"p b\" d=\"{}\"/><path class=\"p a\" d=\"{}\"/>{}",
        view.line(&nominal.way_m),
        view.line(&model.way_m),
        view.bar()
    )
}

/// From metres to one drawing.
struct View {
    middle: [f64; 2],
    scale: f64,
}

impl View {
    /// With room for all of these.
    fn of<'a>(points: impl Iterator<Item = &'a [f64; 2]>) -> Self {
        let (low, high) = bounds(points);
        let scale = ((WIDTH - 2.0 * PAD) / (high[0] - low[0]).max(0.05))
            .min((HEIGHT - 2.0 * PAD - 16.0) / (high[1] - low[1]).max(0.05));
        Self { middle: [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0], scale }
    }

    fn at(&self, p: &[f64; 2]) -> (Px, Px) {
        (
            Px(WIDTH / 2.0 + (p[0] - self.middle[0]) * self.scale),
            Px((HEIGHT - 16.0) / 2.0 - (p[1] - self.middle[1]) * self.scale),
        )
    }

    fn line(&self, points: &[[f64; 2]]) -> String {
        let every = points.len().div_ceil(240).max(1);
        let mut data = String::new();
        for (k, point) in points.iter().enumerate() {
            if k % every == 0 || k + 1 == points.len() {
                let (x, y) = self.at(point);
                let _ = write!(data, "{}{x} {y}", if data.is_empty() { 'M' } else { 'L' });
            }
        }
        data
    }

    /// How long something is.
    fn bar(&self) -> String {
        let bar_m = nice_step(WIDTH / self.scale, 6.0);
        format!(
            "<path class=\"zero\" d=\"M{x0} {y0}h{length}m0 -3v6m-{length} -6v6\"/><text class=\"tick\" x=\"{tx}\" y=\"{ty}\">{}</text>",
            bar_text(bar_m),
            x0 = Px(PAD),
            y0 = Px(HEIGHT - 10.0),
            length = Px(bar_m * self.scale),
            tx = Px(PAD + bar_m * self.scale + 8.0),
            ty = Px(HEIGHT - 6.0),
        )
    }
}

fn bar_text(metres: f64) -> String {
    if metres < 0.1 { format!("{} mm", number(metres * 1e3, 0)) } else { format!("{metres} m") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_that_are_off_are_drawn_though_others_err_more_before() {
        let path = |index: usize| Path {
            run: format!("run_{index}"),
            kind: RunKind::Straight,
            held_out: false,
            measured_m: vec![[0.0, 0.0], [1.0, 0.0]],
            predicted_m: vec![[0.0, 0.0], [1.0, 1e-3 * index as f64]],
            way_m: Vec::new(),
        };
        let paths: Vec<Path> = (0..20).map(path).collect();
        let worst: Vec<usize> = (11..20).collect();
        assert_eq!(chosen(&paths, &[]), worst);
        let with_off = [&[3], &worst[1..]].concat();
        assert_eq!(chosen(&paths, &["run_3".to_owned()]), with_off);
    }
}
