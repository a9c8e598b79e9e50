//! How far is a model off over whole runs? Each run is predicted open loop from its best start, and simulated many
//! times with noise alone for comparison.

use super::rms::Rms;
use super::simulated_run::SimulatedRun;
use super::stretch::tracks;
use crate::effect::composition::Term;
use crate::estimation::predict::open_loop_as_seen;
use crate::estimation::predict::{PoseError, PredictedTrack};
use crate::kinematics::pose::Pose;
use crate::numeric::parallel;
use crate::numeric::random::Random;
use crate::recording::campaign::{Prepared, PreparedRun};
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::run::PoseMeasurement;
use crate::recording::run_kind::RunKind;

/// Number of simulations of each run with drawn noise.
const DRAWS: usize = 100;
/// Index of the 99th percentile among them.
const PERCENTILE_99: usize = 98;

/// One run, predicted and measured.
#[derive(Clone, Debug, PartialEq)]
pub struct RunCompared {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: RunKind,
    /// Whether it is held out: nothing is fitted to it, and it counts in no other figure.
    pub held_out: bool,
    /// Length of the path, forwards and backwards \[m\].
    pub path_m: f64,
    /// Sum of all turns, left and right alike \[rad\].
    pub turned_rad: f64,
    /// Duration \[s\].
    pub duration_s: f64,
    /// Distance between predicted and measured places \[m\]; `None` if no place was measured.
    pub position_m: Option<Rms>,
    /// Between headings \[rad\]; `None` if none was measured.
    pub heading_rad: Option<Rms>,
    /// Distance at the last measurement of the place \[m\].
    pub end_m: Option<f64>,
    sums: Sums,
}

/// A predicted and a measured path, to be drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Name of the run.
    pub run: String,
    /// Its kind.
    pub kind: RunKind,
    /// Whether it is held out.
    pub held_out: bool,
    /// Measured positions \[m\].
    pub measured_m: Vec<[f64; 2]>,
    /// Positions that the model predicts for the same times \[m\].
    pub predicted_m: Vec<[f64; 2]>,
    /// The predicted path between them, if few positions were measured, as at both ends alone; else empty \[m\].
    pub way_m: Vec<[f64; 2]>,
}

/// One run with its measured poses, and what a model predicts for the same times from its best start.
#[derive(Clone, Debug, PartialEq)]
pub struct RunPredicted {
    /// Name of the run.
    pub run: String,
    /// Its kind.
    pub kind: RunKind,
    /// Whether it is held out.
    pub held_out: bool,
    /// What was measured, by the clock of the wheels.
    pub measured: Vec<PoseMeasurement>,
    /// What is predicted, one pose for each measurement.
    pub predicted: Vec<Pose>,
}

impl Path {
    /// The path as far as it is known: measured, or predicted between few measured positions.
    pub fn shape_m(&self) -> &[[f64; 2]] {
        if self.way_m.is_empty() { &self.measured_m } else { &self.way_m }
    }
}

/// With more measured poses than this, they show the path by themselves.
const SPARSE_POSES_MAX: usize = 8;
/// Number of points of a predicted path.
const WAY_POINTS: usize = 200;

/// The predicted path between the measured poses, if these are few; from the same start as theirs.
fn way(run: &PreparedRun, terms: &[Term<'_>]) -> Vec<Pose> {
    let seen = &run.recording.measured_poses;
    if seen.len() > SPARSE_POSES_MAX || run.recording.wheels.len() <= seen.len() {
        return Vec::new();
    }
    let every = run.recording.wheels.len().div_ceil(WAY_POINTS).max(1);
    let between = run.recording.wheels.iter().step_by(every).map(|sample| PoseMeasurement {
        t_s: sample.t_s,
        position_m: None,
        heading_rad: None,
    });
    let apart =
        |measurement: &PoseMeasurement| seen.iter().all(|other| other.t_s != measurement.t_s);
    let mut measurements: Vec<PoseMeasurement> =
        seen.iter().copied().chain(between.filter(apart)).collect();
    measurements.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    open_loop_as_seen(&run.motion, &measurements, terms).predicted
}

/// Squared errors of one run, as measured and in each simulation with drawn noise.
#[derive(Clone, Debug, Default, PartialEq)]
struct Sums {
    measured: Squares,
    drawn: Vec<Squares>,
}

/// Sum and count of squared errors: of positions, of headings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Squares {
    sum: [f64; 2],
    count: [f64; 2],
}

impl Squares {
    fn of(errors: &[PoseError]) -> Self {
        let mut squares = Self::default();
        for error in errors {
            if let Some([ahead_m, left_m]) = error.position_m {
                squares.sum[0] += ahead_m * ahead_m + left_m * left_m;
                squares.count[0] += 1.0;
            }
            if let Some(heading_rad) = error.heading_rad {
                squares.sum[1] += heading_rad * heading_rad;
                squares.count[1] += 1.0;
            }
        }
        squares
    }

    fn mean(self, i: usize) -> f64 {
        self.sum[i] / self.count[i].max(1.0)
    }
}

/// Compares each run with the model; `first` is the number of the first one, which seeds its noise.
pub(super) fn runs(
    first: usize,
    prepared: &Prepared,
    terms: &[Term<'_>],
    noise: &OdometryNoise,
) -> Vec<RunCompared> {
    let tracks = tracks(prepared, terms);
    let both: Vec<(usize, &PreparedRun, &PredictedTrack)> = prepared
        .runs
        .iter()
        .zip(&tracks)
        .enumerate()
        .map(|(index, (run, track))| (first + index, run, track))
        .collect();
    parallel::map(&both, |(index, run, track)| compared(*index, run, track, noise))
}

fn scales(noise: &OdometryNoise) -> (f64, f64) {
    let position_m = noise.position_sigma_m.hypot(noise.position_wobble_m);
    (position_m, noise.heading_sigma_rad.hypot(noise.heading_wobble_rad))
}

fn compared(
    index: usize,
    run: &PreparedRun,
    track: &PredictedTrack,
    noise: &OdometryNoise,
) -> RunCompared {
    let (position_m, heading_rad) = scales(noise);
    let errors = track.errors(position_m, heading_rad);
    let end = errors.iter().rev().find_map(|error| error.position_m);
    let measured = Squares::of(&errors);
    let mut simulated = SimulatedRun::new(run, track, noise);
    let mut random = Random::new(index as u64 + 1);
    let drawn: Vec<Squares> = (0..DRAWS)
        .map(|_| Squares::of(&simulated.draw(&mut random).errors(position_m, heading_rad)))
        .collect();
    let steps = &run.motion.steps;
    let sums = Sums { measured, drawn };
    let [position, heading] = rms(std::slice::from_ref(&&sums));
    RunCompared {
        name: run.recording.name.clone(),
        kind: run.kind,
        held_out: run.recording.held_out,
        path_m: steps.iter().map(|step| step.travel_m().abs()).sum(),
        turned_rad: steps.iter().map(|step| step.turn_rad().abs()).sum(),
        duration_s: run.recording.duration_s(),
        position_m: (measured.count[0] > 0.0).then_some(position),
        heading_rad: (measured.count[1] > 0.0).then_some(heading),
        end_m: end.map(|[ahead_m, left_m]| ahead_m.hypot(left_m)),
        sums,
    }
}

/// Over all runs: positions, headings.
pub(super) fn overall(runs: &[RunCompared]) -> [Rms; 2] {
    rms(&runs.iter().map(|run| &run.sums).collect::<Vec<_>>())
}

fn rms(runs: &[&Sums]) -> [Rms; 2] {
    core::array::from_fn(|i| {
        // Each run's twins have fewer measurements than itself, so they are weighed by its own.
        let count: f64 = runs.iter().map(|sums| sums.measured.count[i]).sum();
        let root = |of: &dyn Fn(&Sums) -> f64| {
            let sum: f64 = runs.iter().map(|sums| sums.measured.count[i] * of(sums)).sum();
            (sum / count.max(1.0)).sqrt()
        };
        let mut simulated: Vec<f64> =
            (0..DRAWS).map(|draw| root(&|squares| squares.drawn[draw].mean(i))).collect();
        let noise = (simulated.iter().map(|rms| rms * rms).sum::<f64>() / DRAWS as f64).sqrt();
        simulated.sort_by(f64::total_cmp);
        Rms {
            rms: root(&|squares| squares.measured.mean(i)),
            noise,
            noise_high: simulated[PERCENTILE_99],
        }
    })
}

pub(super) fn predicted(
    prepared: &Prepared,
    terms: &[Term<'_>],
    noise: &OdometryNoise,
) -> Vec<RunPredicted> {
    let (position_m, heading_rad) = scales(noise);
    let tracks = tracks(prepared, terms).into_iter().zip(&prepared.runs);
    let run = |(track, run): (PredictedTrack, &PreparedRun)| {
        let start = track.best_start(position_m, heading_rad).unwrap_or(Pose::ORIGIN);
        RunPredicted {
            run: run.recording.name.clone(),
            kind: run.kind,
            held_out: run.recording.held_out,
            predicted: track.predicted.iter().map(|pose| start.compose(*pose)).collect(),
            measured: track.measured,
        }
    };
    tracks.map(run).collect()
}

pub(super) fn paths(prepared: &Prepared, terms: &[Term<'_>], noise: &OdometryNoise) -> Vec<Path> {
    let (position_m, heading_rad) = scales(noise);
    tracks(prepared, terms)
        .iter()
        .zip(&prepared.runs)
        .map(|(track, run)| {
            let start = track.best_start(position_m, heading_rad).unwrap_or(Pose::ORIGIN);
            let seen = track.measured.iter().zip(&track.predicted);
            let both =
                seen.filter_map(|(measurement, pose)| Some((measurement.position_m?, *pose)));
            let (measured_m, predicted): (Vec<_>, Vec<_>) = both.unzip();
            Path {
                run: run.recording.name.clone(),
                kind: run.kind,
                held_out: run.recording.held_out,
                measured_m,
                predicted_m: predicted
                    .into_iter()
                    .map(|pose| start.compose(pose))
                    .map(|pose| [pose.x_m, pose.y_m])
                    .collect(),
                way_m: way(run, terms)
                    .into_iter()
                    .map(|pose| start.compose(pose))
                    .map(|pose| [pose.x_m, pose.y_m])
                    .collect(),
            }
        })
        .collect()
}
