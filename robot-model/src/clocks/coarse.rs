//! Offsets of clocks of up to half a minute: the lag at which the speeds and turn rates of wheels and poses agree.
//!
//! Both are sampled on one grid as means over a window; for every lag, with w the wheels' and z the poses' numbers and
//! a the best factors (a wrong radius or track width must not matter):
//!
//! ```text
//! misfit(lag) = sum over the overlap of (z - a w(t - lag))^2 / sum of z^2                (1)
//! ```
//!
//! A lag counts if its misfit is far below that of no lag.

use crate::numeric::angle::wrap;
use crate::numeric::parallel;
use crate::recording::campaign::Campaign;
use crate::recording::run::{Recording, RecordingError, Robot};

/// Spacing of the grid, and of the lags \[s\].
pub(super) const GRID_S: f64 = 0.05;
/// Half of the window of a speed \[s\].
const HALF_WINDOW_S: f64 = 0.2;
/// The longest lag \[s\].
const LAG_MAX_S: f64 = 30.0;
/// Shorter lags are found better from the tracks \[s\].
const LAG_MIN_S: f64 = 0.3;
/// A lag has to leave at most this share of the misfit without a lag, and at most this misfit.
const MISFIT_SHARE_MAX: f64 = 0.4;
const MISFIT_MAX: f64 = 0.3;
/// A lag is certain only if lags that are no neighbours of it fit worse by this factor.
const RIVAL_FACTOR: f64 = 1.5;
/// A longer run has times in another unit, or is no run \[s\].
const RUN_MAX_S: f64 = 10_000.0;
/// Lags further apart than this are no neighbours \[s\].
const NEIGHBOUR_S: f64 = 1.0;

/// Speed and turn rate on the grid, in metres a second at the middle and at the rim; `None` where there is nothing.
struct Signal {
    start_s: f64,
    values: Vec<Option<[f64; 2]>>,
}

/// Shifts the poses of runs whose clocks are far apart; the runs, and how late their poses were \[s\].
pub(super) fn align(campaign: &mut Campaign) -> Result<Vec<(String, f64)>, RecordingError> {
    let robot = campaign.robot;
    let lags = parallel::map(&campaign.runs, |run| run.validate().map(|()| lag_s(&robot, run)));
    let lags: Vec<Option<f64>> = lags.into_iter().collect::<Result<_, _>>()?;
    // A lag that runs agree about also holds for runs that are too short to show it.
    let mut told: Vec<f64> = lags.iter().flatten().copied().collect();
    told.sort_by(f64::total_cmp);
    let common_s = match told.get(told.len() / 2) {
        Some(middle_s) => {
            let near = told.iter().filter(|lag_s| (**lag_s - middle_s).abs() < 2.0 * GRID_S);
            (2 * near.count() > campaign.runs.len() && middle_s.abs() >= LAG_MIN_S)
                .then_some(*middle_s)
        }
        None => None,
    };
    let mut shifted = Vec::new();
    for (run, lag_s) in campaign.runs.iter_mut().zip(lags) {
        let lag_s = match (lag_s, common_s) {
            (Some(lag_s), Some(common_s)) if (lag_s - common_s).abs() <= 2.0 * GRID_S => common_s,
            (None, Some(common_s)) => common_s,
            (Some(lag_s), _) if lag_s.abs() >= LAG_MIN_S => lag_s,
            _ => continue,
        };
        run.measured_poses.iter_mut().for_each(|pose| pose.t_s -= lag_s);
        shifted.push((run.name.clone(), lag_s));
    }
    Ok(shifted)
}

/// How late the poses of a run are, if its motion tells \[s\].
fn lag_s(robot: &Robot, run: &Recording) -> Option<f64> {
    let poses_s = run.measured_poses.first().zip(run.measured_poses.last());
    let poses_s = poses_s.map_or(0.0, |(first, last)| last.t_s - first.t_s);
    if run.duration_s().max(poses_s) > RUN_MAX_S {
        return None;
    }
    let (wheels, poses) = (of_wheels(robot, run), of_poses(robot, run)?);
    let most = (LAG_MAX_S / GRID_S) as i64;
    let between = ((poses.start_s - wheels.start_s) / GRID_S).round() as i64;
    let energies = poses.energies();
    let misfits: Vec<(i64, f64)> = (-most..=most)
        .filter_map(|lag| Some((lag, misfit(&wheels, &poses, energies, between - lag)?)))
        .collect();
    let here = misfits.iter().find(|(lag, _)| *lag == 0).map_or(1.0, |(_, misfit)| *misfit);
    let (lag, least) = misfits.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let apart = (NEIGHBOUR_S / GRID_S) as i64;
    let rival = misfits
        .iter()
        .filter(|(other, _)| (other - lag).abs() > apart)
        .map(|(_, misfit)| *misfit)
        .fold(f64::INFINITY, f64::min);
    let certain =
        least < MISFIT_MAX && least < MISFIT_SHARE_MAX * here && RIVAL_FACTOR * least < rival;
    let stays = here < MISFIT_MAX && lag as f64 * GRID_S < LAG_MIN_S;
    (certain || stays).then_some(if certain { lag as f64 * GRID_S } else { 0.0 })
}

impl Signal {
    /// Sums of the squares of both numbers.
    fn energies(&self) -> [f64; 2] {
        let each = self.values.iter().flatten();
        each.fold([0.0; 2], |sum, z| [sum[0] + z[0] * z[0], sum[1] + z[1] * z[1]])
    }
}

/// Equation (1), with the wheels' grid `shift` places before the poses', whose energies are given; `None` if too little
/// of the motion overlaps.
fn misfit(wheels: &Signal, poses: &Signal, energies: [f64; 2], shift: i64) -> Option<f64> {
    let all = energies[0] + energies[1];
    let (mut products, mut squares, mut overlap) = ([0.0; 2], [0.0; 2], 0.0);
    // Before and after its recording, a robot stands.
    let first = usize::try_from(-shift).unwrap_or(0).min(poses.values.len());
    let beside = usize::try_from(shift).unwrap_or(0).min(wheels.values.len());
    for (z, w) in poses.values[first..].iter().zip(&wheels.values[beside..]) {
        let (Some(z), Some(w)) = (z, w) else { continue };
        overlap += if *w == [0.0; 2] { 0.0 } else { z[0] * z[0] + z[1] * z[1] };
        for axis in 0..2 {
            products[axis] += z[axis] * w[axis];
            squares[axis] += w[axis] * w[axis];
        }
    }
    if all <= 0.0 || overlap < 0.5 * all {
        return None;
    }
    let left: f64 = (0..2)
        .map(|axis| {
            let explained = products[axis] * products[axis].abs() / squares[axis].max(1e-12);
            energies[axis] - explained
        })
        .sum();
    Some(left / all)
}

fn of_wheels(robot: &Robot, run: &Recording) -> Signal {
    let times: Vec<f64> = run.wheels.iter().map(|sample| sample.t_s).collect();
    let numbers = |t_s: f64| -> [f64; 2] {
        let after = times.partition_point(|time_s| *time_s <= t_s).clamp(1, times.len() - 1);
        let (a, b) = (&run.wheels[after - 1], &run.wheels[after]);
        let share = ((t_s - a.t_s) / (b.t_s - a.t_s)).clamp(0.0, 1.0);
        let phi = a.phi_rad.zip(b.phi_rad).map(|(a, b)| a + (b - a) * share);
        [robot.wheel_radius_m * phi.mean(), robot.wheel_radius_m * phi.difference() / 2.0]
    };
    let (start_s, end_s) = (times[0], times[times.len() - 1]);
    let value = |t_s: f64| {
        let (from, to) = (numbers(t_s - HALF_WINDOW_S), numbers(t_s + HALF_WINDOW_S));
        Some([0, 1].map(|axis| (to[axis] - from[axis]) / (2.0 * HALF_WINDOW_S)))
    };
    let count = ((end_s - start_s) / GRID_S) as usize + 1;
    Signal { start_s, values: (0..count).map(|k| value(start_s + k as f64 * GRID_S)).collect() }
}

/// `None` with fewer poses than a speed needs. The sign of the speed is that of the motion along the heading, where
/// headings were measured.
fn of_poses(robot: &Robot, run: &Recording) -> Option<Signal> {
    let poses: Vec<(f64, [f64; 2], Option<f64>)> = run
        .measured_poses
        .iter()
        .filter_map(|pose| Some((pose.t_s, pose.position_m?, pose.heading_rad)))
        .collect();
    let (first, last) = (poses.first()?, poses.last()?);
    let has_headings = poses.iter().all(|(_, _, heading)| heading.is_some());
    if poses.len() < 10 || !has_headings {
        return None;
    }
    let near = |t_s: f64| {
        let after = poses.partition_point(|(time_s, ..)| *time_s < t_s);
        let candidates = [after.saturating_sub(1), after.min(poses.len() - 1)];
        let distance = |index: &usize| (poses[*index].0 - t_s).abs();
        candidates.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
    };
    let value = |t_s: f64| {
        let (a, b) = (&poses[near(t_s - HALF_WINDOW_S)], &poses[near(t_s + HALF_WINDOW_S)]);
        let span_s = b.0 - a.0;
        if !(HALF_WINDOW_S..4.0 * HALF_WINDOW_S).contains(&span_s) {
            return None;
        }
        let (from_rad, to_rad) = (a.2?, b.2?);
        let turn_rad = wrap(to_rad - from_rad);
        let (sin, cos) = (from_rad + turn_rad / 2.0).sin_cos();
        let ahead_m = cos * (b.1[0] - a.1[0]) + sin * (b.1[1] - a.1[1]);
        Some([ahead_m / span_s, turn_rad * robot.track_width_m / 2.0 / span_s])
    };
    let count = ((last.0 - first.0) / GRID_S) as usize + 1;
    let start_s = first.0;
    Some(Signal {
        start_s,
        values: (0..count).map(|k| value(start_s + k as f64 * GRID_S)).collect(),
    })
}
