//! Do two clocks drift apart from run to run? A straight line through the offsets of the runs of one log.
//!
//! ```text
//! offset of a run = offset + rate (time of the middle of its poses - middle of the log)                      (1)
//! ```
//!
//! Every offset is found alone, and weighs by its standard error; what is far from the line is left out once.

use super::{coarse, fine};
use crate::numeric::median::median;
use crate::recording::campaign::Campaign;
use crate::recording::run::RecordingError;

/// How two clocks drift apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// By which share the poses' clock runs faster than that of the wheels.
    pub rate: f64,
    /// Its standard error, widened by how far runs are from the line.
    pub sigma: f64,
    /// When both agree, by the clock of `Recording::started_s` \[s\].
    pub middle_s: f64,
}

/// So many runs tell a line, and more are spread over the log.
const RUNS: (usize, usize) = (4, 48);
/// A drift is told if it is so many standard errors, and over the log so long \[s\].
const SIGMAS: f64 = 6.0;
const OVER_LOG_S: f64 = 3e-3;
/// So many times the median distance from the line is far.
const FAR_TIMES: f64 = 5.0;

/// The drift of the clocks of a campaign whose runs say when they began, if it shows.
pub fn drift(campaign: &Campaign) -> Result<Option<Drift>, RecordingError> {
    let started: Vec<usize> =
        (0..campaign.runs.len()).filter(|run| campaign.runs[*run].started_s.is_some()).collect();
    if started.len() < RUNS.0 {
        return Ok(None);
    }
    let every = started.len().div_ceil(RUNS.1);
    let runs = started.iter().step_by(every).map(|run| campaign.runs[*run].clone());
    let mut few = Campaign { robot: campaign.robot, runs: runs.collect() };
    few.runs.iter_mut().for_each(|run| run.held_out = false);
    let coarse_s = coarse::align(&mut few)?;
    let prepared = few.prepare_lighter()?;
    let mut points = Vec::new();
    for (run, line) in prepared.runs.iter().zip(fine::lines(&prepared)) {
        let (Some(line), Some(started_s)) = (line, run.recording.started_s) else { continue };
        let name = &run.recording.name;
        let shifted_s =
            coarse_s.iter().find(|(shifted, _)| shifted == name).map_or(0.0, |(_, s)| *s);
        let sigma_s = line.offset_sigma_s.max(fine::OFFSET_SIGMA_MIN_S);
        let offset_s = shifted_s + line.offset_s;
        points.push([started_s + line.middle_s, offset_s, sigma_s.powi(-2)]);
    }
    let Some(rough) = through(&points) else { return Ok(None) };
    let far_s = |[t_s, offset_s, _]: &[f64; 3]| (offset_s - rough.at(*t_s)).abs();
    let Some(usual_s) = median(points.iter().map(far_s).collect()) else { return Ok(None) };
    points.retain(|point| far_s(point) <= FAR_TIMES * usual_s.max(fine::OFFSET_SIGMA_MIN_S));
    Ok(through(&points).and_then(|line| line.told(&points)))
}

/// Equation (1).
struct Line {
    middle_s: f64,
    offset_s: f64,
    rate: f64,
    sigma: f64,
}

impl Line {
    fn at(&self, t_s: f64) -> f64 {
        self.offset_s + self.rate * (t_s - self.middle_s)
    }

    fn told(&self, points: &[[f64; 3]]) -> Option<Drift> {
        let times_s = points.iter().map(|[t_s, ..]| *t_s);
        let span_s = times_s.clone().fold(f64::NEG_INFINITY, f64::max)
            - times_s.fold(f64::INFINITY, f64::min);
        let is_told =
            self.rate.abs() > SIGMAS * self.sigma && self.rate.abs() * span_s > OVER_LOG_S;
        is_told.then_some(Drift { rate: self.rate, sigma: self.sigma, middle_s: self.middle_s })
    }
}

/// The line through these points of time, offset and weight.
fn through(points: &[[f64; 3]]) -> Option<Line> {
    let weight: f64 = points.iter().map(|[_, _, weight]| weight).sum();
    let mean = |of: usize| points.iter().map(|point| point[of] * point[2]).sum::<f64>() / weight;
    let (middle_s, offset_s) = (mean(0), mean(1));
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        points.iter().map(|[t_s, s, weight]| weight * of(t_s - middle_s, s - offset_s)).sum()
    };
    let square = sum(&|t, _| t * t);
    if points.len() < RUNS.0 || square.is_nan() || square <= 0.0 {
        return None;
    }
    let rate = sum(&|t, s| t * s) / square;
    let left = sum(&|t, s| (s - rate * t).powi(2)) / (points.len() as f64 - 2.0);
    Some(Line { middle_s, offset_s, rate, sigma: left.sqrt().max(1.0) / square.sqrt() })
}
