//! One rate for all runs: two clocks keep it from run to run, so short runs together tell what none tells alone.
//!
//! With windows j of runs i, their offsets o, times t and weights w, and t' and o' without the means of their run:
//!
//! ```text
//! rate = sum of w t' o' / sum of w t'^2                                                                        (1)
//! ```
//!
//! Its standard error is widened by how far windows are from these lines, and by how far rates of single runs differ.
//!
//! A clock that runs fast from the start of a run is late by more, the longer the run is. So offsets are told at the
//! starts of the runs, where they are the same for all.

use super::line::Line;
use crate::numeric::median::median;
use crate::recording::campaign::Prepared;

/// Fewest windows beyond those that the offsets of the runs need.
const FREE_MIN: f64 = 4.0;
/// A rate is told if it is so many standard errors (nine short runs of a real robot gave a false one of 2.3 % at 7), and over the longest run so long \[s\].
const SIGMAS: f64 = 12.0;
const OVER_RUN_S: f64 = 0.02;
/// A run that alone is so many standard errors off the common rate, and so large a share of it, has one of its own.
const OTHER_SIGMAS: f64 = 4.0;
const OTHER_SHARE: f64 = 0.2;
/// Over a run longer than this, a rate is found too roughly at first to be told from that of another run \[s\].
const ROUGH_S: f64 = 0.3;
/// Less than this share of its standard error is not worth another round.
const NOTHING_SIGMAS: f64 = 0.1;
/// How well the offset of a run is known that is too short to tell one \[s\].
const UNKNOWN_S: f64 = 1.0;

/// The rate that all runs have.
#[derive(Clone, Copy, Debug)]
pub(super) struct CommonRate {
    pub(super) rate: f64,
    pub(super) sigma: f64,
    longest_s: f64,
}

/// Sums over the windows of one run, about its mean.
struct RunSums {
    square: f64,
    product: f64,
    offsets: f64,
    windows: f64,
    span_s: f64,
}

impl CommonRate {
    /// Equation (1) for points of time, offset and weight of each run; what they scatter by at least is given.
    pub(super) fn of(points: &[Vec<[f64; 3]>], scatter_min: f64) -> Option<Self> {
        let runs: Vec<RunSums> = points.iter().filter_map(|points| RunSums::of(points)).collect();
        let square: f64 = runs.iter().map(|run| run.square).sum();
        let free = runs.iter().map(|run| run.windows - 1.0).sum::<f64>() - 1.0;
        if free < FREE_MIN || square <= 0.0 {
            return None;
        }
        let rate = runs.iter().map(|run| run.product).sum::<f64>() / square;
        let left: f64 = runs
            .iter()
            .map(|run| run.offsets - 2.0 * rate * run.product + rate * rate * run.square)
            .sum();
        let between: f64 =
            runs.iter().map(|run| run.square * (run.product / run.square - rate).powi(2)).sum();
        let between = between / (runs.len() as f64 - 1.0).max(1.0);
        let scatter = (left / free).max(between).sqrt().max(scatter_min);
        let longest_s = runs.iter().map(|run| run.span_s).fold(0.0, f64::max);
        Some(Self { rate, sigma: scatter / square.sqrt(), longest_s })
    }

    /// Whether it is beyond chance, large enough to matter, and no run has clearly another.
    pub(super) fn is_told_by_all(&self, lines: &[Option<Line>]) -> bool {
        let over_run_s = self.rate.abs() * self.longest_s;
        let differs = lines.iter().flatten().any(|line| self.is_other(line));
        self.rate.abs() > SIGMAS * self.sigma
            && over_run_s > OVER_RUN_S
            && (over_run_s > ROUGH_S || !differs)
    }

    /// Whether what is left of it is too little for another round.
    pub(super) fn is_nothing(&self) -> bool {
        self.rate.abs() < NOTHING_SIGMAS * self.sigma
    }

    /// Gives it to the lines of all runs, about their starts, also to those that are too short to have one.
    pub(super) fn give_to(&self, lines: &mut [Option<Line>], prepared: &Prepared) {
        let starts_s = prepared.runs.iter().map(|run| run.motion.start_s);
        for (line, start_s) in lines.iter_mut().zip(starts_s.clone()) {
            let Some(line) = line else { continue };
            line.offset_s -= self.rate * (line.middle_s - start_s);
            (line.middle_s, line.rate, line.rate_sigma) = (start_s, self.rate, self.sigma);
        }
        let known = lines.iter().flatten().map(|line| line.offset_s).collect();
        let Some(offset_s) = median(known) else { return };
        for (line, middle_s) in lines.iter_mut().zip(starts_s) {
            line.get_or_insert(Line {
                middle_s,
                span_s: self.longest_s,
                offset_s,
                offset_sigma_s: UNKNOWN_S,
                rate: self.rate,
                rate_sigma: self.sigma,
            });
        }
    }

    /// Whether a run has clearly another rate.
    fn is_other(&self, line: &Line) -> bool {
        let off = (line.rate - self.rate).abs();
        let slack = (OTHER_SIGMAS * line.rate_sigma).max(OTHER_SHARE * self.rate.abs());
        line.tells_rate() && off > slack
    }
}

impl RunSums {
    fn of(points: &[[f64; 3]]) -> Option<Self> {
        let weight: f64 = points.iter().map(|[_, _, weight]| weight).sum();
        if points.len() < 2 || weight <= 0.0 {
            return None;
        }
        let mean =
            |of: usize| points.iter().map(|point| point[of] * point[2]).sum::<f64>() / weight;
        let (middle_s, offset_s) = (mean(0), mean(1));
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            points.iter().map(|[t_s, o_s, w]| w * of(t_s - middle_s, o_s - offset_s)).sum()
        };
        let sums = Self {
            square: sum(&|t_s, _| t_s * t_s),
            product: sum(&|t_s, o_s| t_s * o_s),
            offsets: sum(&|_, o_s| o_s * o_s),
            windows: points.len() as f64,
            span_s: points[points.len() - 1][0] - points[0][0],
        };
        (sums.square > 0.0).then_some(sums)
    }
}
