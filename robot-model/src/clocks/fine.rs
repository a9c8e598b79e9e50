//! Offset and rate of the clocks of each run, from the filter: in each window of a run an offset of its own, and a
//! straight line through the offsets of all windows.
//!
//! The filter lets the error of dead reckoning grow, so a window's offset comes from where speeds change, and hardly
//! from errors that grow along the path. By how much windows of a run disagree, its standard errors are widened.

use super::clock_found::ClockFound;
use super::common_rate::CommonRate;
use super::corrections::{Correction, corrections};
use super::line::{Line, line};
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
/// An offset is reported if it is this many standard errors from zero.
const REPORTED_SIGMAS: f64 = 2.0;
/// No offset is known better than this \[s\].
pub(super) const OFFSET_SIGMA_MIN_S: f64 = 1e-3;
/// So far clocks of runs may differ while the geometry is fitted, one sigma \[s\].
const CLOCK_SPREAD_S: f64 = 0.05;
/// From this misfit on, a tracker whose noise nobody gave is taken to be as noisy as that.
const NOISIER: f64 = 2.0;
/// Offsets and rates are found anew after each correction; more often where a rate of all runs was found, as offsets of
/// tenths of a second come near only step by step.
const ROUNDS: usize = 2;
const ROUNDS_WITH_RATE: usize = 8;

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

/// Corrects the times of poses, in the prepared runs and in the campaign, and gives what was taken out of each run, nothing
/// included. Of runs that were shifted already, all of the offset is taken out: how much of it is a camera's delay cannot
/// be told.
pub(super) fn align(
    prepared: &mut Prepared,
    campaign: &mut Campaign,
    is_shifted: impl Fn(&str) -> bool,
    may_share_rate: bool,
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
    let mut has_common = false;
    for round in 0..ROUNDS_WITH_RATE {
        if round >= ROUNDS && !has_common {
            break;
        }
        let points = points(prepared);
        let mut lines: Vec<Option<Line>> =
            points.of_run.iter().map(|points| line(points)).collect();
        let common = CommonRate::of(&points.of_run, points.scatter_min)
            .filter(|_| may_share_rate)
            .filter(|common| has_common || common.is_told_by_all(&lines));
        if round >= ROUNDS && common.is_some_and(|common| common.is_nothing()) {
            break;
        }
        if let Some(common) = common {
            common.give_to(&mut lines, prepared);
            has_common = true;
        }
        let corrections = corrections(&lines, &shifted, common);
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
            // Of the time that the poses' clock tells, what has been taken out.
            let share = 1.0 - (1.0 - clock.rate / (1.0 + clock.rate)) * (1.0 - rate);
            clock.rate = share / (1.0 - share);
            clock.rate_sigma = line.rate_sigma;
        }
    }
    clocks
}

/// Whether a clock is worth a word: its offset is beyond chance, or it has a rate.
pub(super) fn is_reported(clock: &ClockFound) -> bool {
    clock.offset_s.abs() > REPORTED_SIGMAS * clock.offset_sigma_s || clock.rate != 0.0
}

/// Offset and rate of each run; `None` where its poses do not tell.
pub(super) fn lines(prepared: &Prepared) -> Vec<Option<Line>> {
    points(prepared).of_run.iter().map(|points| line(points)).collect()
}

/// Time, offset and weight of the windows of each run.
struct Points {
    of_run: Vec<Vec<[f64; 3]>>,
    /// What they scatter by if nothing but the noise that was assumed is there.
    scatter_min: f64,
}

fn points(prepared: &Prepared) -> Points {
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
    let mut of_run: Vec<Vec<[f64; 3]>> = vec![Vec::new(); prepared.runs.len()];
    for offset in &offsets {
        let (index, middle_s) = places[offset.window];
        of_run[index].push([middle_s, offset.offset_s, offset.weight / widened.powi(2)]);
    }
    Points { of_run, scatter_min: widened.recip() }
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
    // Where clocks may be off by much, a data sheet that is far off passes for clocks: it is mended first.
    let near = fit_parameters(prepared, geometry, noise).terms;
    let noise = OdometryNoise { clock_offset_s: CLOCK_SPREAD_S, ..noise };
    let mut terms = fit_parameters(prepared, near, noise).terms;
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
