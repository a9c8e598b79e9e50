//! Offset and rate of the clocks of each run, from the filter: in each window of a run an offset of its own, and a
//! straight line through the offsets of all windows.
//!
//! The filter lets the error of dead reckoning grow, so a window's offset comes from where speeds change, and hardly
//! from errors that grow along the path. By how much windows of a run disagree, its standard errors are widened.

use super::clock_found::ClockFound;
use crate::effect::catalogue::CATALOGUE;
use crate::effect::composition::{PlacedTerm, Term};
use crate::effect::definition::{Effect, Facts, Group, Parameter, View};
use crate::estimation::campaign_equations::{CampaignEquations, Fold};
use crate::estimation::fit::fit_parameters;
use crate::numeric::jet::{Jet, PARAMETERS_MAX};
use crate::numeric::median::median;
use crate::recording::campaign::{Campaign, Prepared, PreparedRun};
use crate::recording::motion::Motion;
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::run::{PoseMeasurement, Recording};

/// Length of a window \[s\].
const WINDOW_S: f64 = 12.0;
/// Fewest poses in a window.
const POSES_MIN: usize = 8;
/// A window has the wheels from so long before its first pose to so long after its last \[s\].
const MARGIN_S: f64 = 1.0;
/// From this many points on, a line tells a rate.
pub(super) const POINTS_FOR_RATE: usize = 5;
/// What all runs share, up to this, is the delay of a camera and left to the effects, as long as no clock is wrong \[s\].
const DELAY_MAX_S: f64 = 0.25;
/// An offset of a run that differs from the common one is corrected from this on \[s\], and beyond chance.
const OFFSET_MIN_S: f64 = 0.015;
/// A rate is corrected if over the run it amounts to this \[s\], and beyond chance.
const RATE_MIN_S: f64 = 0.02;
/// Beyond chance: so many standard errors.
const SIGMAS: f64 = 6.0;
/// An offset is reported if it is this many standard errors from zero.
const REPORTED_SIGMAS: f64 = 2.0;
/// No offset is known better than this \[s\].
pub(super) const OFFSET_SIGMA_MIN_S: f64 = 1e-3;
/// So far clocks of runs may differ while the geometry is fitted, one sigma \[s\].
const CLOCK_SPREAD_S: f64 = 0.05;
/// From this misfit on, a tracker whose noise nobody gave is taken to be as noisy as that.
const NOISIER: f64 = 2.0;
/// Offsets and rates are found anew after each correction.
const ROUNDS: usize = 2;

/// Poses that are late.
#[derive(Debug)]
struct Late;

impl Effect for Late {
    fn facts(&self) -> Facts<'_> {
        static FACTS: Facts<'static> = Facts {
            id: "late",
            parameters: &[Parameter::amplitude("tau", "s", 1.0)],
            ..Facts::DEFAULT
        };
        FACTS
    }

    fn observe(&self, p: &[Jet; PARAMETERS_MAX]) -> View {
        View { delay_s: p[0], ..View::NONE }
    }
}

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
}

/// What is taken out of a run.
#[derive(Clone, Copy, Debug)]
struct Correction {
    offset_s: f64,
    offset_sigma_s: f64,
    rate: f64,
}

/// Corrects the times of poses, in the prepared runs and in the campaign, and gives what was taken out of each run, nothing
/// included. Of runs that were shifted already, all of the offset is taken out: how much of it is a camera's delay cannot
/// be told.
pub(super) fn align(
    prepared: &mut Prepared,
    campaign: &mut Campaign,
    is_shifted: impl Fn(&str) -> bool,
) -> Vec<ClockFound> {
    let shifted: Vec<bool> =
        prepared.runs.iter().map(|run| is_shifted(&run.recording.name)).collect();
    let names = prepared.runs.iter().map(|run| run.recording.name.clone());
    let mut clocks: Vec<ClockFound> = names
        .map(|run| ClockFound {
            run,
            offset_s: 0.0,
            offset_sigma_s: 0.0,
            rate: 0.0,
            rate_sigma: 0.0,
        })
        .collect();
    for _ in 0..ROUNDS {
        let lines = lines(prepared);
        let corrections = corrections(&lines, &shifted);
        if corrections.iter().all(Option::is_none) {
            break;
        }
        for ((run, clock), (line, correction)) in
            prepared.runs.iter_mut().zip(&mut clocks).zip(lines.iter().zip(&corrections))
        {
            let Some(Correction { offset_s, offset_sigma_s, rate }) = *correction else { continue };
            let line = line.unwrap_or_default();
            let name = &run.recording.name;
            let recorded = campaign.runs.iter_mut().find(|recorded| recorded.name == *name);
            let recorded = recorded.map(|recorded| &mut recorded.measured_poses);
            for pose in recorded.into_iter().chain([&mut run.recording.measured_poses]).flatten() {
                pose.t_s -= offset_s + rate * (pose.t_s - line.middle_s);
            }
            clock.offset_s += offset_s;
            clock.offset_sigma_s = offset_sigma_s.max(OFFSET_SIGMA_MIN_S);
            clock.rate += rate;
            clock.rate_sigma = line.rate_sigma;
        }
    }
    clocks
}

/// Whether a clock is worth a word: its offset is beyond chance, or it has a rate.
pub(super) fn is_reported(clock: &ClockFound) -> bool {
    clock.offset_s.abs() > REPORTED_SIGMAS * clock.offset_sigma_s || clock.rate != 0.0
}

/// The offset and rate to be taken out of each run.
fn corrections(lines: &[Option<Line>], shifted: &[bool]) -> Vec<Option<Correction>> {
    let mut offsets: Vec<f64> = lines.iter().flatten().map(|line| line.offset_s).collect();
    offsets.sort_by(f64::total_cmp);
    let Some(median_s) = offsets.get(offsets.len() / 2).copied() else {
        return vec![None; lines.len()];
    };
    let most_shifted = 2 * shifted.iter().filter(|shifted| **shifted).count() > lines.len();
    let differs = |line: &Line| {
        let off_s = (line.offset_s - median_s).abs();
        off_s > OFFSET_MIN_S && off_s > SIGMAS * line.offset_sigma_s
    };
    let (centre_s, spread_s2) = scatter(lines);
    // If one run has an offset of its own, all may have. Otherwise all have the same, also those that cannot tell.
    let any = lines.iter().flatten().any(differs);
    let stays_s =
        if median_s.abs() < DELAY_MAX_S && !most_shifted && !any { median_s } else { 0.0 };
    let common = (most_shifted && !any).then(|| mean(lines));
    lines
        .iter()
        .zip(shifted)
        .map(|(line, shifted)| {
            if let (Some((offset_s, offset_sigma_s)), true) = (common, *shifted) {
                return Some(Correction { offset_s, offset_sigma_s, rate: 0.0 });
            }
            let line = (*line)?;
            let sure = spread_s2 / (spread_s2 + line.offset_sigma_s.powi(2));
            let offset_s = match (shifted, any) {
                (true, _) => line.offset_s - stays_s,
                (false, true) if differs(&line) => line.offset_s,
                // What a run hardly tells is taken for what runs differ by.
                (false, true) => centre_s + sure * (line.offset_s - centre_s),
                (false, false) => 0.0,
            };
            let over_run_s = line.rate.abs() * line.span_s;
            let certain = line.rate_sigma > 0.0 && line.rate.abs() > SIGMAS * line.rate_sigma;
            let rate = if certain && over_run_s > RATE_MIN_S { line.rate } else { 0.0 };
            let offset_sigma_s = line.offset_sigma_s;
            let found = Correction { offset_s, offset_sigma_s, rate };
            (offset_s != 0.0 || rate != 0.0).then_some(found)
        })
        .collect()
}

/// The mean and the variance of the true offsets of these runs \[s, s^2\].
fn scatter(lines: &[Option<Line>]) -> (f64, f64) {
    let mut known: Vec<&Line> = lines.iter().flatten().collect();
    known.sort_by(|a, b| a.offset_sigma_s.total_cmp(&b.offset_sigma_s));
    // Those that tell it best, as the others add their own errors.
    known.truncate(known.len().div_ceil(2).max(3));
    let n = known.len().max(1) as f64;
    let mean_s = known.iter().map(|line| line.offset_s).sum::<f64>() / n;
    let excess = |line: &&Line| (line.offset_s - mean_s).powi(2) - line.offset_sigma_s.powi(2);
    (mean_s, (known.iter().map(excess).sum::<f64>() / n).max(1e-8))
}

/// The mean offset of these runs, by their standard errors, and its own \[s\].
fn mean(lines: &[Option<Line>]) -> (f64, f64) {
    let weight = |line: &Line| line.offset_sigma_s.max(1e-4).powi(-2);
    let (sum, weights) = lines.iter().flatten().fold((0.0, 0.0), |(sum, weights), line| {
        (sum + weight(line) * line.offset_s, weights + weight(line))
    });
    let weights = weights.max(f64::MIN_POSITIVE);
    (sum / weights, weights.sqrt().recip())
}

/// Offset and rate of each run; `None` where its poses do not tell.
pub(super) fn lines(prepared: &Prepared) -> Vec<Option<Line>> {
    let robot = &prepared.robot;
    let typical = OdometryNoise::TYPICAL;
    let noise = OdometryNoise {
        position_sigma_m: robot.position_sigma_m.unwrap_or(typical.position_sigma_m),
        heading_sigma_rad: robot.heading_sigma_rad.unwrap_or(typical.heading_sigma_rad),
        ..typical
    };
    let (places, runs): (Vec<(usize, f64)>, Vec<PreparedRun>) = prepared
        .runs
        .iter()
        .enumerate()
        .flat_map(|(index, run)| {
            windows(run).into_iter().map(move |(middle_s, window)| ((index, middle_s), window))
        })
        .unzip();
    let cut = Prepared { runs, held_out: Vec::new(), dense: None, ..*prepared };
    let mut offsets = window_offsets(prepared, &cut, noise);
    let misfit = misfit(&offsets);
    if misfit > NOISIER && (robot.position_sigma_m.is_none() || robot.heading_sigma_rad.is_none()) {
        // A tracker that is noisier than most: weighted as if it were none, each window believes its last poses.
        let noisier = OdometryNoise {
            position_sigma_m: robot.position_sigma_m.unwrap_or(misfit * typical.position_sigma_m),
            heading_sigma_rad: robot
                .heading_sigma_rad
                .unwrap_or(misfit * typical.heading_sigma_rad),
            ..noise
        };
        offsets = window_offsets(prepared, &cut, noisier);
    }
    let widened = self::misfit(&offsets).max(1.0);
    let mut points: Vec<Vec<[f64; 3]>> = vec![Vec::new(); prepared.runs.len()];
    for offset in &offsets {
        let (index, middle_s) = places[offset.window];
        points[index].push([middle_s, offset.offset_s, offset.weight / widened.powi(2)]);
    }
    points.iter().map(|points| line(points)).collect()
}

/// What the poses of one window tell about its offset.
#[derive(Clone, Copy, Debug)]
struct WindowOffset {
    window: usize,
    offset_s: f64,
    /// By the noise that was assumed \[1/s^2\].
    weight: f64,
    /// What is left, against what this noise leaves: a mean of squares.
    chi_squared: f64,
}

/// The offset of each window, about the geometry that fits all runs best with this noise.
fn window_offsets(prepared: &Prepared, cut: &Prepared, noise: OdometryNoise) -> Vec<WindowOffset> {
    let geometry = CATALOGUE.iter().filter(|effect| effect.facts().group == Group::Geometry);
    let geometry = geometry.map(|effect| Term::new(*effect, vec![0.0])).collect();
    let noise = OdometryNoise { clock_offset_s: CLOCK_SPREAD_S, ..noise };
    let mut terms = fit_parameters(prepared, geometry, noise).terms;
    terms.push(Term::new(&Late, vec![0.0]));
    let terms = PlacedTerm::place(&terms);
    let column = terms.last().map_or(0, |late| late.columns().start);
    let noise = OdometryNoise { clock_offset_s: 1e-5, ..noise };
    let equations = CampaignEquations::gather(cut, &terms, &noise);
    let of_window = |fold: &Fold| {
        let (weight, right) = (fold.sums.gram[(column, column)], fold.sums.right[column]);
        let left = fold.sums.squares - right * right / weight;
        (weight > 0.0).then_some(WindowOffset {
            window: fold.run,
            offset_s: right / weight,
            weight,
            chi_squared: left / fold.sums.rows,
        })
    };
    equations.folds.iter().filter_map(of_window).collect()
}

/// By which factor the poses are off more than the noise that was assumed, in the median window.
fn misfit(offsets: &[WindowOffset]) -> f64 {
    median(offsets.iter().map(|offset| offset.chi_squared).collect()).unwrap_or(1.0).sqrt()
}

/// Consecutive poses of a run, with the middle of their times.
fn windows(run: &PreparedRun) -> Vec<(f64, PreparedRun)> {
    let poses = &run.recording.measured_poses;
    let Some((first, last)) = poses.first().zip(poses.last()) else { return Vec::new() };
    let span_s = last.t_s - first.t_s;
    let count = (span_s / WINDOW_S).round().max(2.0);
    let edge = |k: f64| first.t_s + span_s * k / count;
    let (mut windows, mut k) = (Vec::new(), 0.0);
    while k < count {
        let (from_s, to_s) = (edge(k), edge(k + 1.0));
        let begin = poses.partition_point(|pose| pose.t_s < from_s);
        let end = poses.partition_point(|pose| pose.t_s <= to_s);
        let Some(next) = poses.get(begin) else { break };
        if end >= begin + POSES_MIN {
            windows.push(((from_s + to_s) / 2.0, window(run, poses[begin..end].to_vec())));
        }
        // A clock that jumps by years leaves windows without a pose: as many as it likes, and they are not looked at.
        let of_next = ((next.t_s - first.t_s) / span_s * count).floor();
        k = if end == begin { of_next.max(k + 1.0) } else { k + 1.0 };
        if k + 1.0 <= k {
            break;
        }
    }
    windows
}

/// A run as long as these poses of it.
fn window(run: &PreparedRun, poses: Vec<PoseMeasurement>) -> PreparedRun {
    let wheels = &run.recording.wheels;
    let (from_s, to_s) = (poses[0].t_s - MARGIN_S, poses[poses.len() - 1].t_s + MARGIN_S);
    let last = wheels.len() - 1;
    let first = wheels.partition_point(|sample| sample.t_s < from_s).min(last - 1);
    let last = wheels.partition_point(|sample| sample.t_s < to_s).clamp(first + 1, last);
    let recording = Recording {
        name: run.recording.name.clone(),
        wheels: wheels[first..=last].to_vec(),
        measured_poses: poses,
        ..Recording::default()
    };
    let steps = run.motion.steps[first..last].to_vec();
    let motion = Motion { start_s: recording.wheels[0].t_s, steps };
    PreparedRun { recording, motion, kind: run.kind }
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
