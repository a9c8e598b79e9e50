//! The floor from above: all runs, how much of the residuals each place would explain, and the place that is named, if
//! one is.

use std::fmt::Write;

use robot_model::residuals::{PlaceSeen, Regressor};

use super::campaign_report::CampaignReport;
use crate::calibration_page::scale::{Px, Scale, bounds, grid_columns, nice_step, number, ticks};

const WIDTH_MAX: f64 = 940.0;
const HEIGHT_MAX: f64 = 560.0;
/// Room for the numbers at the left and below.
const LEFT: f64 = 48.0;
const PAD: f64 = 26.0;
/// Radius of the ring round the place that is named \[m\]: a cell of the grid that was searched.
const RING_M: f64 = 0.15;
/// The darkest cell.
const OPACITY_MAX: f64 = 0.8;

/// The drawing, if the residuals depend on the place.
pub(super) fn draw(report: &CampaignReport<'_>) -> Option<String> {
    let unexplained = &report.answer.unexplained;
    if !unexplained.depends_on.contains(&Regressor::Place) {
        return None;
    }
    let paths = report.paths[1];
    let shapes = paths.iter().flat_map(|path| path.shape_m());
    let (low, high) = bounds(shapes.chain(&unexplained.place_m));
    let span = [0, 1].map(|k| high[k] - low[k] + 2.0 * RING_M);
    let per_m = ((WIDTH_MAX - LEFT - PAD) / span[0]).min((HEIGHT_MAX - 2.0 * PAD) / span[1]);
    let width = span[0] * per_m + LEFT + PAD;
    let height = span[1] * per_m + 2.0 * PAD;
    let x = Scale::new(low[0] - RING_M, LEFT, per_m);
    let y = Scale::new(low[1] - RING_M, height - PAD, -per_m);
    let mut svg = format!(
        "<figure><svg class=\"d thin\" style=\"max-width:{w}px\" viewBox=\"0 0 {w} {}\" role=\"img\" aria-label=\"The floor, and the place that \
         the residuals depend on\">",
        Px(height),
        w = Px(width)
    );
    grid(&mut svg, (low, high), (x, y), [width, height]);
    let most = unexplained.places.iter().map(|place| place.gain).fold(0.0, f64::max);
    let side = PlaceSeen::SIDE_M;
    for place in unexplained.places.iter().filter(|place| place.gain > 0.0) {
        let _ = write!(
            svg,
            "<rect class=\"fb\" fill-opacity=\"{:.2}\" x=\"{}\" y=\"{}\" width=\"{w}\" height=\"{w}\"/>",
            OPACITY_MAX * place.gain / most,
            x.at(place.at_m[0] - side / 2.0),
            y.at(place.at_m[1] + side / 2.0),
            w = Px(side * per_m)
        );
    }
    for path in paths {
        let every = path.shape_m().len().div_ceil(240).max(1);
        let mut data = String::new();
        for [to_x, to_y] in path.shape_m().iter().step_by(every) {
            let letter = if data.is_empty() { 'M' } else { 'L' };
            let _ = write!(data, "{letter}{} {}", x.at(*to_x), y.at(*to_y));
        }
        let _ = write!(svg, "<path class=\"p way\" d=\"{data}\"/>");
    }
    let of_ring = match unexplained.place_m {
        Some(place_m) => {
            ring(&mut svg, place_m, (x, y), [width, per_m]);
            " The ring is the place named above, from a finer search."
        }
        None => " No single place stands out.",
    };
    Some(format!(
        "<p class=\"sub\">All runs from above. Squares are the places that wheels of several runs passed, half a track \
         width beside these paths: the darker, the more of the residuals a place would explain.{of_ring}</p>\n\
         {svg}</svg></figure>\n"
    ))
}

/// The ring round the place that is named, and its coordinates.
fn ring(svg: &mut String, place_m: [f64; 2], (x, y): (Scale, Scale), [width, per_m]: [f64; 2]) {
    let (at_x, at_y) = (x.at(place_m[0]), y.at(place_m[1]));
    let ring = RING_M * per_m;
    // The words stand where there is room.
    let (side, anchor) = if at_x.0 < width / 2.0 { (1.0, "start") } else { (-1.0, "end") };
    let _ = write!(
        svg,
        "<circle class=\"p a\" cx=\"{at_x}\" cy=\"{at_y}\" r=\"{}\"/>\
         <text class=\"q named\" x=\"{}\" y=\"{}\" text-anchor=\"{anchor}\">x {} m, y {} m</text>",
        Px(ring),
        Px(at_x.0 + side * (ring + 8.0)),
        Px(at_y.0 - ring),
        number(place_m[0], 2),
        number(place_m[1], 2)
    );
}

/// Metres, as lines.
fn grid(
    svg: &mut String,
    (low, high): ([f64; 2], [f64; 2]),
    (x, y): (Scale, Scale),
    [width, height]: [f64; 2],
) {
    let step_m = nice_step((high[0] - low[0]).max(high[1] - low[1]).max(0.1), 8.0);
    let columns = ticks((low[0], high[0]), step_m);
    grid_columns(svg, &x, columns, (PAD, height - PAD), height - 8.0);
    let (levels, places) = ticks((low[1], high[1]), step_m);
    for level in levels {
        let at = y.at(level);
        let _ = write!(
            svg,
            "<path class=\"g\" d=\"M{} {at}H{}\"/><text class=\"tick\" x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
            Px(LEFT),
            Px(width - PAD),
            Px(LEFT - 8.0),
            Px(at.0 + 4.0),
            number(level, places)
        );
    }
    let _ = write!(
        svg,
        "<text class=\"tick\" x=\"{}\" y=\"14\">y, m</text><text class=\"tick\" x=\"{}\" y=\"{}\" text-anchor=\"end\">x, m</text>",
        Px(4.0),
        Px(width - 2.0),
        Px(height - 8.0)
    );
}
