//! Do two clocks drift apart from run to run? A straight line through the offsets of the runs of one log.
//!
//! ```text
//! offset of a run = offset + rate (time of the middle of its poses - middle of the log)                      (1)
//! ```
//!
//! Every offset is found alone, and weighs by its standard error; what is far from the line is left out once.

use super::line::{Line, POINTS_FOR_RATE, line as straight_line};
use super::{coarse, fine};
use crate::numeric::median::median;
use crate::recording::campaign::Campaign;
use crate::recording::condense::WheelSamples;
use crate::recording::run::{Recording, RecordingError};

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

/// Of more runs, so many are looked at, spread over the log.
const RUNS_MAX: usize = 48;
/// A drift is told if it is so many standard errors, and over the log so long \[s\].
const SIGMAS: f64 = 6.0;
const OVER_LOG_S: f64 = 3e-3;
/// So many times the median distance from the line is far.
const FAR_TIMES: f64 = 5.0;

/// The drift of the clocks of a campaign whose runs say when they began, in their order, if it shows.
pub fn drift(campaign: &Campaign) -> Result<Option<Drift>, RecordingError> {
    let started: Vec<&Recording> =
        campaign.runs.iter().filter(|run| run.started_s.is_some()).collect();
    if started.len() < POINTS_FOR_RATE {
        return Ok(None);
    }
    let every = started.len().div_ceil(RUNS_MAX);
    let runs = started.into_iter().step_by(every).cloned().collect();
    let mut few = Campaign { robot: campaign.robot, runs };
    few.runs.iter_mut().for_each(|run| run.held_out = false);
    let coarse_s = coarse::align(&mut few)?;
    let prepared = few.prepare_lighter(WheelSamples::Even)?;
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
    let Some(rough) = straight_line(&points) else { return Ok(None) };
    let far_s = |[t_s, offset_s, _]: &[f64; 3]| (offset_s - rough.at(*t_s)).abs();
    let Some(usual_s) = median(points.iter().map(far_s).collect()) else { return Ok(None) };
    points.retain(|point| far_s(point) <= FAR_TIMES * usual_s.max(fine::OFFSET_SIGMA_MIN_S));
    let is_told = |line: &Line| {
        let over_log_s = line.rate.abs() * line.span_s;
        line.rate.abs() > SIGMAS * line.rate_sigma && over_log_s > OVER_LOG_S
    };
    Ok(straight_line(&points).filter(is_told).map(|line| Drift {
        rate: line.rate,
        sigma: line.rate_sigma,
        middle_s: line.middle_s,
    }))
}
