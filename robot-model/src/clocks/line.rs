//! The straight line through the offsets of the windows of a run.

/// From this many points on, a line tells a rate.
pub(super) const POINTS_FOR_RATE: usize = 5;
/// A rate is corrected if over the run it amounts to this \[s\], and beyond chance.
const RATE_MIN_S: f64 = 0.02;
/// Beyond chance: so many standard errors.
pub(super) const SIGMAS: f64 = 6.0;

/// Offset and rate of one run, about the middle of its poses.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Line {
    pub(super) middle_s: f64,
    pub(super) span_s: f64,
    pub(super) offset_s: f64,
    pub(super) offset_sigma_s: f64,
    pub(super) rate: f64,
    pub(super) rate_sigma: f64,
}

impl Line {
    /// The offset at a time \[s\].
    pub(super) fn at(&self, t_s: f64) -> f64 {
        self.offset_s + self.rate * (t_s - self.middle_s)
    }

    /// Whether it has a rate that is beyond chance, and large enough to matter.
    pub(super) fn tells_rate(&self) -> bool {
        let certain = self.rate_sigma > 0.0 && self.rate.abs() > SIGMAS * self.rate_sigma;
        certain && self.rate.abs() * self.span_s > RATE_MIN_S
    }
}

/// The straight line through points of time, offset and weight.
pub(super) fn line(points: &[[f64; 3]]) -> Option<Line> {
    let weight: f64 = points.iter().map(|[_, _, weight]| weight).sum();
    if points.len() < 2 || weight <= 0.0 {
        return None;
    }
    let mean = |of: usize| points.iter().map(|point| point[of] * point[2]).sum::<f64>() / weight;
    let (middle_s, offset_s) = (mean(0), mean(1));
    let square: f64 = points.iter().map(|[t_s, _, weight]| weight * (t_s - middle_s).powi(2)).sum();
    let product: f64 = points
        .iter()
        .map(|[t_s, tau_s, weight]| weight * (t_s - middle_s) * (tau_s - offset_s))
        .sum();
    let has_rate = points.len() >= POINTS_FOR_RATE && square > 0.0;
    let rate = if has_rate { product / square } else { 0.0 };
    let left: f64 = points
        .iter()
        .map(|[t_s, tau_s, weight]| weight * (tau_s - offset_s - rate * (t_s - middle_s)).powi(2))
        .sum();
    let free = points.len() as f64 - if has_rate { 2.0 } else { 1.0 };
    let widened = (left / free).sqrt().max(1.0);
    let (first, last) = (points[0][0], points[points.len() - 1][0]);
    Some(Line {
        middle_s,
        span_s: last - first,
        offset_s,
        offset_sigma_s: widened / weight.sqrt(),
        rate,
        rate_sigma: if has_rate { widened / square.sqrt() } else { 0.0 },
    })
}
