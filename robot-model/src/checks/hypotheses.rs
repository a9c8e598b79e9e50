//! What is wrong with the data of a campaign? Every hypothesis is fitted to the tracks, and the best is reported.

use core::cmp::Ordering;

use crate::recording::run::{PoseMeasurement, Recording, Robot, WheelSample};

use super::all_runs::{all_runs, rms};
use super::counters::{self, Wrapping};
use super::data_fault::{DataFault, DataHypothesis};
use super::geometry_fit::{Tracks, lever_m};
use super::last_pose::last_poses;
use super::one_run::one_run;
use super::relative_geometry::RelativeGeometry;
use super::start_pose_fit::{Fit, lateness};
use super::thinned_run::ThinnedRun;
use super::tracker;

/// A run that nothing explains is reported from this multiple of the error on that a run in order has, if it has poses
/// enough.
const UNKNOWN_TIMES: f64 = 28.0;
const POSES_MIN: usize = 5;
/// More such runs than this, and than a quarter of all, have one cause.
const UNKNOWN_MAX: usize = 2;
/// A mended event is reported if the error falls to this share.
const EVENT: f64 = 0.6;
/// Two ways to mend counts do as well if the error of one is at most this many times that of the other.
const ALIKE_TIMES: f64 = 2.0;
/// Held values are reported only if they do harm: the error falls to this share, from this one \[m\].
const HELD: (f64, f64) = (0.4, 0.006);

/// What is wrong with the data of these valid runs, the best first: what all runs share, then the worst runs, then
/// what fits can live with. Empty if nothing is; a robot that is merely inaccurate gives nothing.
pub fn data_hypotheses(robot: &Robot, runs: &[Recording]) -> Vec<DataHypothesis> {
    let events: Vec<Events> = runs.iter().map(|run| Events::of(robot, run)).collect();
    let tracks = |events: &[Events]| {
        let track = |events: &Events| ThinnedRun::of(robot, &events.wheels, &events.poses);
        Tracks::new(robot, events.iter().map(track).collect())
    };
    let before = tracks(&events);
    let mut solution = before.solve(&RelativeGeometry::NOMINAL);
    let mut events = events;
    let mut changed = false;
    for events in &mut events {
        changed |= events.find_in_poses(robot, &solution.geometry);
    }
    let mut tracks = if changed { tracks(&events) } else { before };
    if changed {
        solution = tracks.solve(&RelativeGeometry::NOMINAL);
    }
    let mut found = Vec::new();
    for (run, events) in runs.iter().zip(&events) {
        found.extend(events.hypotheses(robot, run, &solution.geometry));
    }
    let far = tracks.far(&solution);
    let many = far.len() > 1 || far.len() == 1 && runs.len() == 1;
    if let (true, Some(all)) = (many, all_runs(&tracks, &solution)) {
        found.push(all.hypothesis);
        tracks = Tracks::new(robot, all.tracks);
        solution = all.solution;
    }
    // The geometry of a mended data sheet is no geometry of the one that is: single runs are left for then.
    if !found.iter().any(|found| found.run.is_none() && is_of_robot(&found.what)) {
        found.extend(of_runs(robot, runs, &tracks, &solution.geometry, &solution.late_s, &found));
    }
    found.sort_by(by_importance);
    found
}

/// Whether this concerns the robot's data sheet.
fn is_of_robot(what: &DataFault) -> bool {
    matches!(what, DataFault::Radius { .. } | DataFault::Track { .. } | DataFault::Lengths { .. })
}

/// What is wrong with single runs, by the geometry of all.
fn of_runs(
    robot: &Robot,
    runs: &[Recording],
    tracks: &Tracks,
    geometry: &RelativeGeometry,
    late_s: &[f64],
    told: &[DataHypothesis],
) -> Vec<DataHypothesis> {
    let mut found = Vec::new();
    let mut unknown = Vec::new();
    let mut open: Vec<bool> = runs
        .iter()
        .map(|run| {
            let is_told = |told: &DataHypothesis| {
                told.run.as_ref() == Some(&run.name) && !told.what.is_minor()
            };
            !told.iter().any(is_told)
        })
        .collect();
    let fits: Vec<Fit> = (0..runs.len())
        .map(|run| {
            let track = &tracks.each[run];
            Fit::robust(track, &track.reckon(robot, geometry), late_s[run], tracks.lever_m)
        })
        .collect();
    for (run, fit) in fits.iter().enumerate() {
        if !open[run] || !tracks.is_far(run, fit.error_m) {
            continue;
        }
        if let (true, Some(mut hypothesis)) = (runs.len() > 1, one_run(tracks, run, geometry)) {
            hypothesis.run = Some(runs[run].name.clone());
            found.push(hypothesis);
            open[run] = false;
        } else if tracks.each[run].poses.len() >= POSES_MIN
            && tracks.is_far(run, fit.error_m * super::geometry_fit::FAR / UNKNOWN_TIMES)
        {
            unknown.push(run);
            open[run] = false;
        }
    }
    if unknown.len() > UNKNOWN_MAX && 4 * unknown.len() > runs.len() {
        found.push(of_unknown_cause(None, rms(unknown.iter().map(|run| fits[*run].error_m))));
        return found;
    }
    found.extend(
        unknown.iter().map(|run| of_unknown_cause(Some(&runs[*run].name), fits[*run].error_m)),
    );
    let ends = last_poses(robot, runs, tracks, geometry, &open);
    found.extend(ends.into_iter().zip(runs).zip(&fits).filter_map(|((off, run), fit)| {
        let off = off?;
        Some(DataHypothesis {
            what: DataFault::LastPose {
                t_s: off.t_s,
                position_m: off.position_m,
                heading_rad: off.heading_rad,
            },
            run: Some(run.name.clone()),
            or: Vec::new(),
            error_m: off
                .position_m
                .unwrap_or_else(|| off.heading_rad.unwrap_or(0.0).abs() * tracks.lever_m),
            mended_m: fit.error_m,
            next: None,
        })
    }));
    found
}

/// What no hypothesis mends, of one run or of all.
fn of_unknown_cause(run: Option<&String>, error_m: f64) -> DataHypothesis {
    DataHypothesis {
        what: DataFault::Unknown,
        run: run.cloned(),
        or: Vec::new(),
        error_m,
        mended_m: error_m,
        next: None,
    }
}

fn by_importance(a: &DataHypothesis, b: &DataHypothesis) -> Ordering {
    let key = |found: &DataHypothesis| (found.what.is_minor(), found.run.is_some());
    key(a).cmp(&key(b)).then(b.error_m.total_cmp(&a.error_m))
}

/// What happened within a run: its wheels and poses without it.
struct Events {
    wheels: Vec<WheelSample>,
    poses: Vec<PoseMeasurement>,
    in_counts: Vec<DataFault>,
    in_poses: Vec<DataFault>,
}

impl Events {
    fn of(robot: &Robot, run: &Recording) -> Self {
        let counters::Mended { wheels, found } = counts_mended(robot, run);
        Self { wheels, poses: run.measured_poses.clone(), in_counts: found, in_poses: Vec::new() }
    }

    /// Finds what happened to the tracker, by this geometry; whether anything did that mends the run.
    fn find_in_poses(&mut self, robot: &Robot, geometry: &RelativeGeometry) -> bool {
        let track = ThinnedRun::of(robot, &self.wheels, &[]).with(&self.poses);
        let reckoned = track.reckon(robot, geometry);
        let tracker::Mended { poses, found } = tracker::mended(&track, &reckoned, lever_m(robot));
        if found.is_empty() {
            return false;
        }
        let before = error_m(robot, &self.wheels, &self.poses, geometry);
        let after = error_m(robot, &self.wheels, &poses, geometry);
        if after > EVENT * before {
            return false;
        }
        (self.poses, self.in_poses) = (poses, found);
        true
    }

    /// What is reported of a run, with its evidence.
    fn hypotheses(
        &self,
        robot: &Robot,
        run: &Recording,
        geometry: &RelativeGeometry,
    ) -> Vec<DataHypothesis> {
        if self.in_counts.is_empty() && self.in_poses.is_empty() {
            return Vec::new();
        }
        let after = error_m(robot, &self.wheels, &self.poses, geometry);
        let told = |what: &DataFault, wheels: &[WheelSample], poses: &[PoseMeasurement]| {
            let before = error_m(robot, wheels, poses, geometry);
            let is_held =
                matches!(what, DataFault::CountsHeld { .. } | DataFault::PosesHeld { .. });
            let harmless = is_held && (before < HELD.1 || after > HELD.0 * before);
            let worsens = !what.is_minor() && after > before;
            (!harmless && !worsens).then(|| DataHypothesis {
                what: *what,
                run: Some(run.name.clone()),
                or: Vec::new(),
                error_m: before,
                mended_m: after,
                next: None,
            })
        };
        let in_counts =
            self.in_counts.iter().filter_map(|what| told(what, &run.wheels, &self.poses));
        let in_poses =
            self.in_poses.iter().filter_map(|what| told(what, &self.wheels, &run.measured_poses));
        in_counts.chain(in_poses).collect()
    }
}

/// The counts of a run, mended. Where a counter went further than 16 bits hold, a step by more than half their range may be a
/// fast wheel's: then it is a wrap only if the run is far better without it.
fn counts_mended(robot: &Robot, run: &Recording) -> counters::Mended {
    let all = counters::mended(robot, run, Wrapping::All);
    if !all.found.iter().any(|what| matches!(what, DataFault::CounterWraps { .. })) {
        return all;
    }
    let sure = counters::mended(robot, run, Wrapping::WithinRange);
    if sure.found == all.found {
        return all;
    }
    let error_m = |wheels: &[WheelSample]| {
        error_m(robot, wheels, &run.measured_poses, &RelativeGeometry::NOMINAL)
    };
    let all_m = error_m(&all.wheels);
    let are_wraps =
        all_m < EVENT * error_m(&run.wheels) && all_m <= ALIKE_TIMES * error_m(&sure.wheels);
    if are_wraps { all } else { sure }
}

/// The error (rms) of all poses, outliers among them \[m\].
fn error_m(
    robot: &Robot,
    wheels: &[WheelSample],
    poses: &[PoseMeasurement],
    geometry: &RelativeGeometry,
) -> f64 {
    let track = &ThinnedRun::of(robot, wheels, &[]).with(poses);
    let reckoned = track.reckon(robot, geometry);
    let lever_m = lever_m(robot);
    let late_s = lateness(track, &reckoned, lever_m);
    Fit::of(track, &reckoned, late_s, lever_m, &vec![true; track.poses.len()]).error_m
}
