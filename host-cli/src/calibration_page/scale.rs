//! Where quantities and ticks are on the page: scales, boxes, steps, and numbers as text.

use std::fmt::{self, Write};

/// A linear scale.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    from: f64,
    at: f64,
    per_unit: f64,
}

impl Scale {
    /// A scale with `from` at coordinate `at`, and `per_unit` between two units.
    pub(crate) fn new(from: f64, at: f64, per_unit: f64) -> Self {
        Self { from, at, per_unit }
    }

    /// A scale from this range to these coordinates.
    pub(crate) fn over(range: (f64, f64), at: (f64, f64)) -> Self {
        Self::new(range.0, at.0, (at.1 - at.0) / (range.1 - range.0))
    }

    pub(crate) fn at(&self, value: f64) -> Px {
        Px(self.at + (value - self.from) * self.per_unit)
    }
}

/// A coordinate, written with two decimals and never as "-0.00"; if not finite, it is drawn at 0.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(crate) struct Px(pub(crate) f64);

impl fmt::Display for Px {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hundredths = if self.0.is_finite() { (self.0 * 100.0).round() } else { 0.0 };
        write!(f, "{}", (hundredths + 0.0) / 100.0)
    }
}

/// The box round points: its lower left and its upper right corner. Points that are not finite are left out.
pub(crate) fn bounds<'a>(points: impl Iterator<Item = &'a [f64; 2]>) -> ([f64; 2], [f64; 2]) {
    let start = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let found = points.filter(|point| point.iter().all(|part| part.is_finite())).fold(
        start,
        |(low, high), p| {
            ([low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])])
        },
    );
    if found.0[0].is_finite() { found } else { ([0.0; 2], [1.0; 2]) }
}

/// The step of 1, 2 or 5 times a power of ten that gives at most `most` steps in `span`.
pub(crate) fn nice_step(span: f64, most: f64) -> f64 {
    let rough = (span / most).max(1e-12);
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * power >= rough * (1.0 - 1e-9));
    step.unwrap_or(10.0) * power
}

/// The multiples of `step` within the range, and the decimals that they need.
pub(crate) fn ticks(range: (f64, f64), step: f64) -> (Vec<f64>, usize) {
    let first = (range.0 / step - 1e-6).ceil() as i64;
    let last = (range.1 / step + 1e-6).floor() as i64;
    let decimals = (-(step * 1.001).log10().floor()).max(0.0) as usize;
    ((first..=last).map(|i| i as f64 * step).collect(), decimals)
}

/// A line and a number at each round value of the vertical axis, from one end of the horizontal one to the other.
pub(crate) fn grid_rows(svg: &mut String, y: &Scale, range: (f64, f64), ends: (f64, f64)) {
    let (levels, decimals) = ticks(range, nice_step(range.1 - range.0, 5.0));
    for level in levels {
        let at = y.at(level);
        let class = if level == 0.0 { "zero" } else { "g" };
        let _ = write!(
            svg,
            "<path class=\"{class}\" d=\"M{} {at}H{}\"/><text class=\"tick\" x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
            Px(ends.0),
            Px(ends.1),
            Px(ends.0 - 8.0),
            Px(at.0 + 4.0),
            number(level, decimals)
        );
    }
}

/// A number with its unit at each round value of the horizontal axis, at most six or so.
pub(crate) fn numbers_below(svg: &mut String, x: &Scale, range: (f64, f64), y: u32, unit: &str) {
    let (stops, decimals) = ticks(range, nice_step(range.1 - range.0, 6.0));
    for stop in stops {
        let _ = write!(
            svg,
            "<text class=\"tick\" x=\"{}\" y=\"{y}\" text-anchor=\"middle\">{}{unit}</text>",
            x.at(stop),
            number(stop, decimals)
        );
    }
}

/// A line from top to bottom, and a number below it at `text_y`, at each of these values of the horizontal axis.
pub(crate) fn grid_columns(
    svg: &mut String,
    x: &Scale,
    (values, decimals): (Vec<f64>, usize),
    (top, bottom): (f64, f64),
    text_y: f64,
) {
    for value in values {
        let at = x.at(value);
        let _ = write!(
            svg,
            "<path class=\"g\" d=\"M{at} {}V{}\"/><text class=\"tick\" x=\"{at}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            Px(top),
            Px(bottom),
            Px(text_y),
            number(value, decimals)
        );
    }
}

/// A number with a real minus sign and fixed decimals, never "-0".
pub(crate) fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| b == b'0' || b == b'.') => rest.to_owned(),
        Some(rest) => format!("\u{2212}{rest}"),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_ticks_are_their_multiples() {
        assert_eq!(nice_step(48.0, 6.0), 10.0);
        assert!((nice_step(0.011, 6.0) - 0.002).abs() < 1e-15);
        assert_eq!(ticks((-45.0, 12.0), 20.0), (vec![-40.0, -20.0, 0.0], 0));
        assert_eq!(ticks((0.0, 1.8), 0.5).1, 1);
    }

    #[test]
    fn no_coordinate_is_nan_or_minus_zero() {
        assert_eq!(Px(f64::NAN).to_string(), "0");
        assert_eq!(Px(-0.001).to_string(), "0");
        assert_eq!(Px(-1.257).to_string(), "-1.26");
        assert_eq!(number(-0.04, 1), "0.0");
    }
}
