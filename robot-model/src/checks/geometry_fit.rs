//! Which radius, ratio of radii and track width make wheels and poses of all runs agree best, within limits?

use nalgebra::{Matrix3, Vector3};

use crate::recording::run::Robot;

use super::relative_geometry::RelativeGeometry;
use super::start_pose_fit::{Fit, lateness};
use super::thinned_run::ThinnedRun;

/// A run is in order if its error is below this much, plus a share of its size; a run with an error of
/// [`FAR`] times that is not.
const NEAR_M: f64 = 0.004;
const NEAR_SHARE: f64 = 0.004;
pub(super) const FAR: f64 = 4.0;
/// A run shows something if its wheels went and turned so many levers, or turned by this \[rad\].
const MOVED: f64 = 0.2;
const MOVED_RAD: f64 = 3.0;
/// Turns beyond this make no larger error \[rad\].
const TURNED_MAX_RAD: f64 = 12.0;
/// Rounds of Gauss-Newton, and for a first look, its numerical step, and the step at which it has converged.
const ROUNDS: usize = 8;
const ROUGH_ROUNDS: usize = 3;
const STEP: f64 = 1e-4;
const DONE: f64 = 1e-4;
/// What no run can show stays where it was: the weight of the data sheet.
const PRIOR: f64 = 0.05;
/// The lever of headings is a track width, if the data sheet has one that a robot can have \[m\].
const LEVER_M: (f64, f64) = (0.05, 1.0);
/// Where the search begins if the data sheet is too far off: factors of the turn, and differences of the radii.
const TURNS: [f64; 13] = [1.0, 0.9, 1.1, 0.82, 1.21, 0.75, 1.33, 0.67, 1.45, 0.6, 1.6, 0.52, 1.9];
const RATIOS: [f64; 3] = [0.0, -0.14, 0.14];

/// Runs, with what they are measured by.
pub(super) struct Tracks<'a> {
    pub(super) robot: &'a Robot,
    pub(super) each: Vec<ThinnedRun>,
    pub(super) lever_m: f64,
    /// The error of each run below which it is in order \[m\].
    near_m: Vec<f64>,
    /// Whether its wheels went or turned far enough to show anything.
    moved: Vec<bool>,
}

/// The geometry that fits best, and what it leaves.
#[derive(Clone, Debug)]
pub(super) struct Solution {
    pub(super) geometry: RelativeGeometry,
    /// How late the poses of each run are \[s\].
    pub(super) late_s: Vec<f64>,
    pub(super) fits: Vec<Fit>,
    cost: f64,
}

impl Solution {
    pub(super) fn errors_m(&self) -> Vec<f64> {
        self.fits.iter().map(|fit| fit.error_m).collect()
    }
}

/// The lever by which an error of heading counts as one of position \[m\].
pub(super) fn lever_m(robot: &Robot) -> f64 {
    robot.track_width_m.clamp(LEVER_M.0, LEVER_M.1)
}

/// The error below which a run is in order \[m\].
fn near_m(robot: &Robot, lever_m: f64, track: &ThinnedRun) -> f64 {
    let turned_m = lever_m * track.turned_rad(robot).min(TURNED_MAX_RAD);
    let turned_m = if track.has_headings() { turned_m } else { 0.0 };
    NEAR_M + NEAR_SHARE * (track.extent_m() + turned_m)
}

impl<'a> Tracks<'a> {
    pub(super) fn new(robot: &'a Robot, each: Vec<ThinnedRun>) -> Self {
        let lever_m = lever_m(robot);
        let near_m = each.iter().map(|track| near_m(robot, lever_m, track));
        let near_m = near_m.collect();
        let moved = each.iter().map(|track| {
            let turned_m = lever_m * track.turned_rad(robot);
            track.rolled_rad() * robot.wheel_radius_m + turned_m > MOVED * lever_m
                || track.rolled_rad() > MOVED_RAD
        });
        let moved = moved.collect();
        Self { robot, each, lever_m, near_m, moved }
    }

    /// Whether a run is far from where its wheels led.
    pub(super) fn is_far(&self, run: usize, error_m: f64) -> bool {
        self.moved[run] && error_m > FAR * self.near_m[run]
    }

    /// Whether an error is beyond that of a part of a run in order.
    pub(super) fn is_off(&self, part: &ThinnedRun, error_m: f64) -> bool {
        error_m > near_m(self.robot, self.lever_m, part)
    }

    /// The error below which a run is in order \[m\].
    pub(super) fn near_m(&self, run: usize) -> f64 {
        self.near_m[run]
    }

    pub(super) fn far(&self, solution: &Solution) -> Vec<usize> {
        let errors = solution.errors_m();
        (0..errors.len()).filter(|run| self.is_far(*run, errors[*run])).collect()
    }

    /// The geometry that fits best, near `center`; if it leaves a run far off, the search begins at other places too.
    pub(super) fn solve(&self, center: &RelativeGeometry) -> Solution {
        let late_s = vec![0.0; self.each.len()];
        let near = self.refined(center, center, late_s);
        if self.far(&near).is_empty() {
            return near;
        }
        let (_, begin) = self.searched(center, &RATIOS, &near.late_s);
        let other = self.refined(&begin, center, near.late_s.clone());
        if other.cost < near.cost { other } else { near }
    }

    /// The least cost near `center`, roughly.
    pub(super) fn rough_cost(&self, center: &RelativeGeometry) -> f64 {
        let late_s = vec![0.0; self.each.len()];
        let near = self.descended(center, center, &late_s, ROUGH_ROUNDS);
        let near = self.cost(&self.fits(&near, &late_s));
        near.min(self.searched(center, &[0.0], &late_s).0)
    }

    /// Tries several turns with these ratios, each with the travel that fits best: the least cost, and where.
    fn searched(
        &self,
        center: &RelativeGeometry,
        ratios: &[f64],
        late_s: &[f64],
    ) -> (f64, RelativeGeometry) {
        let mut best = (f64::INFINITY, *center);
        for turn in TURNS {
            for ratio in ratios {
                let begin = center.moved(&Vector3::new(0.0, turn.ln(), *ratio), center);
                let fits = self.fits(&begin, late_s);
                let sum = |of: fn(&Fit) -> f64| {
                    let each = fits.iter().zip(&self.near_m);
                    each.map(|(fit, near_m)| of(fit) / near_m.powi(2)).sum::<f64>()
                };
                let along = sum(|fit| fit.along_m2) / sum(|fit| fit.by_wheels_m2);
                let by = if along > 0.0 && along.is_finite() { along.ln() } else { 0.0 };
                let there = begin.moved(&Vector3::new(by, 0.0, 0.0), center);
                let times = (there.travel - begin.travel).exp();
                let farther: Vec<Fit> =
                    fits.iter().map(|fit| fit.times(times, self.lever_m)).collect();
                let cost = self.cost(&farther);
                if cost < best.0 {
                    best = (cost, there);
                }
            }
        }
        best
    }

    /// RelativeGeometry, then lateness, in turn.
    fn refined(
        &self,
        begin: &RelativeGeometry,
        center: &RelativeGeometry,
        mut late_s: Vec<f64>,
    ) -> Solution {
        let mut geometry = self.descended(begin, center, &late_s, ROUNDS);
        for _ in 0..2 {
            let fits = self.fits(&geometry, &late_s);
            let off = |run: &usize| fits[*run].error_m > self.near_m[*run];
            let runs: Vec<usize> = (0..self.each.len()).filter(off).collect();
            if runs.is_empty() {
                break;
            }
            for run in runs {
                let track = &self.each[run];
                late_s[run] = lateness(track, &track.reckon(self.robot, &geometry), self.lever_m);
            }
            geometry = self.descended(&geometry, center, &late_s, ROUNDS);
        }
        let fits = self.fits(&geometry, &late_s);
        Solution { geometry, cost: self.cost(&fits), late_s, fits }
    }

    fn fits(&self, geometry: &RelativeGeometry, late_s: &[f64]) -> Vec<Fit> {
        let fit = |(track, late_s): (&ThinnedRun, &f64)| {
            Fit::robust(track, &track.reckon(self.robot, geometry), *late_s, self.lever_m)
        };
        self.each.iter().zip(late_s).map(fit).collect()
    }

    /// Runs that are far off count little (Cauchy): they may be wrong.
    fn cost(&self, fits: &[Fit]) -> f64 {
        let each = fits.iter().zip(&self.near_m);
        each.map(|(fit, near_m)| (fit.error_m / near_m).powi(2).ln_1p()).sum()
    }

    /// Gauss-Newton from `begin`, in so many rounds at most.
    fn descended(
        &self,
        begin: &RelativeGeometry,
        center: &RelativeGeometry,
        late_s: &[f64],
        rounds: usize,
    ) -> RelativeGeometry {
        let mut geometry = *begin;
        let mut fits = self.fits(&geometry, late_s);
        let mut cost = self.cost(&fits);
        for _ in 0..rounds {
            let step = self.step(&geometry, center, late_s, &fits);
            let mut share = 1.0;
            let found = loop {
                let there = geometry.moved(&(step * share), center);
                let there_fits = self.fits(&there, late_s);
                let there_cost = self.cost(&there_fits);
                if there_cost < cost {
                    break Some((there, there_fits, there_cost));
                }
                share /= 3.0;
                if share < 0.03 {
                    break None;
                }
            };
            let Some((there, there_fits, there_cost)) = found else { break };
            let done = (step * share).amax() < DONE || cost - there_cost < 1e-3;
            (geometry, fits, cost) = (there, there_fits, there_cost);
            if done {
                break;
            }
        }
        geometry
    }

    fn step(
        &self,
        geometry: &RelativeGeometry,
        center: &RelativeGeometry,
        late_s: &[f64],
        fits: &[Fit],
    ) -> Vector3<f64> {
        let mut normal = Matrix3::identity() * PRIOR;
        let mut right = Vector3::new(
            center.travel - geometry.travel,
            center.turn - geometry.turn,
            center.ratio - geometry.ratio,
        ) * PRIOR;
        for (run, fit) in fits.iter().enumerate() {
            let track = &self.each[run];
            let at = |there: RelativeGeometry| {
                let reckoned = track.reckon(self.robot, &there);
                Fit::of(track, &reckoned, late_s[run], self.lever_m, &fit.kept).residuals
            };
            let moved = [
                fit.times_with_kept(STEP.exp(), self.lever_m).residuals,
                at(RelativeGeometry { turn: geometry.turn + STEP, ..*geometry }),
                at(RelativeGeometry { ratio: geometry.ratio + STEP, ..*geometry }),
            ];
            let near_m2 = self.near_m[run].powi(2);
            let weight = 1.0 / (track.poses.len().max(1) as f64 * (near_m2 + fit.error_m.powi(2)));
            for (k, residual) in fit.residuals.iter().enumerate() {
                for (axis, value) in residual.iter().enumerate() {
                    let slope = Vector3::from_fn(|j, _| (moved[j][k][axis] - value) / STEP);
                    normal += slope * slope.transpose() * weight;
                    right -= slope * (value * weight);
                }
            }
        }
        normal.cholesky().map_or_else(Vector3::zeros, |factor| factor.solve(&right))
    }

    /// The error of one run that was changed, in a given geometry, however late it is; and how late.
    pub(super) fn error_of(&self, track: &ThinnedRun, geometry: &RelativeGeometry) -> (Fit, f64) {
        let reckoned = track.reckon(self.robot, geometry);
        let late_s = lateness(track, &reckoned, self.lever_m);
        (Fit::robust(track, &reckoned, late_s, self.lever_m), late_s)
    }
}
