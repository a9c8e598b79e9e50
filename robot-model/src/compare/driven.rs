//! Whole runs, driven blindly by the model from the start that suits it best, and what noise alone
//! would have made of them.

use super::rms::Rms;
use super::stretch::tracks;
use crate::effect::composition::Term;
use crate::estimation::odometry_noise::OdometryNoise;
use crate::estimation::predict::open_loop_as_seen;
use crate::estimation::predict::{PoseError, Track};
use crate::kinematics::pose::Pose;
use crate::numeric::parallel;
use crate::numeric::random::Random;
use crate::recording::campaign::{Prepared, PreparedRun};
use crate::recording::motion::Step;
use crate::recording::run::PoseMeasurement;
use crate::recording::run_kind::RunKind;

/// So often each run is driven with made-up noise.
const DRAWS: usize = 100;
/// Of these, the one that 99 % stay below.
const HIGH: usize = 98;
/// A root mean square does not need every measurement: of more than this many, every so many are taken.
const SIGHTS_MAX: usize = 200;

/// One run, predicted and measured.
#[derive(Clone, Debug, PartialEq)]
pub struct RunCompared {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: RunKind,
    /// Whether it is kept aside: nothing is fitted to it, and it counts in no other figure.
    pub held_out: bool,
    /// How long the path is, forwards and backwards \[m\].
    pub path_m: f64,
    /// How much it turned, left and right alike \[rad\].
    pub turned_rad: f64,
    /// How long it took \[s\].
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
    /// Whether it is kept aside.
    pub held_out: bool,
    /// Where it was seen \[m\].
    pub measured_m: Vec<[f64; 2]>,
    /// Where the model says it was then \[m\].
    pub predicted_m: Vec<[f64; 2]>,
    /// Where the model says it went between them, where it was seen seldom, as at both ends alone; else nothing \[m\].
    pub way_m: Vec<[f64; 2]>,
}

impl Path {
    /// Where it was, as far as that is known: as it was seen, or between that as the model says.
    pub fn shape_m(&self) -> &[[f64; 2]] {
        if self.way_m.is_empty() { &self.measured_m } else { &self.way_m }
    }
}

/// Who was seen more often than that shows the way by that.
const SEEN_SELDOM: usize = 8;
/// The way of the others is told by so many points.
const WAY_POINTS: usize = 200;

/// Where a run is by the model between where it was seen, if that is seldom; from the same start as what was seen.
fn way(run: &PreparedRun, terms: &[Term<'_>]) -> Vec<Pose> {
    let seen = &run.recording.measured_poses;
    if seen.len() > SEEN_SELDOM || run.recording.wheels.len() <= seen.len() {
        return Vec::new();
    }
    let every = run.recording.wheels.len().div_ceil(WAY_POINTS).max(1);
    let between = run.recording.wheels.iter().step_by(every).map(|it| PoseMeasurement {
        t_s: it.t_s,
        position_m: None,
        heading_rad: None,
    });
    let apart = |it: &PoseMeasurement| seen.iter().all(|other| other.t_s != it.t_s);
    let mut measurements: Vec<PoseMeasurement> =
        seen.iter().copied().chain(between.filter(apart)).collect();
    measurements.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    open_loop_as_seen(&run.motion, &measurements, terms).predicted
}

/// Squares of one run, and of each of its drawn twins: sums and counts, place and heading.
#[derive(Clone, Debug, Default, PartialEq)]
struct Sums {
    measured: Squares,
    drawn: Vec<Squares>,
}

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

/// The runs, driven by the model; `first` is the number of the first one, which draws its noise.
pub(super) fn runs(
    first: usize,
    prepared: &Prepared,
    terms: &[Term<'_>],
    noise: &OdometryNoise,
) -> Vec<RunCompared> {
    let tracks = tracks(prepared, terms);
    let both: Vec<(usize, &PreparedRun, &Track)> = prepared
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

fn compared(index: usize, run: &PreparedRun, track: &Track, noise: &OdometryNoise) -> RunCompared {
    let (position_m, heading_rad) = scales(noise);
    let errors = track.errors(position_m, heading_rad);
    let end = errors.iter().rev().find_map(|it| it.position_m);
    let measured = Squares::of(&errors);
    let thinned = thinned(track);
    let mut random = Random::new(index as u64 + 1);
    let drawn: Vec<Squares> = (0..DRAWS)
        .map(|_| {
            let twin = drawn(run, &thinned, noise, &mut random);
            Squares::of(&twin.errors(position_m, heading_rad))
        })
        .collect();
    let steps = &run.motion.steps;
    let sums = Sums { measured, drawn };
    let [position, heading] = rms(std::slice::from_ref(&&sums));
    RunCompared {
        name: run.recording.name.clone(),
        kind: run.kind,
        held_out: run.recording.held_out,
        path_m: steps.iter().map(|it| it.travel_m().abs()).sum(),
        turned_rad: steps.iter().map(|it| it.turn_rad().abs()).sum(),
        duration_s: run.recording.duration_s(),
        position_m: (measured.count[0] > 0.0).then_some(position),
        heading_rad: (measured.count[1] > 0.0).then_some(heading),
        end_m: end.map(|[ahead_m, left_m]| ahead_m.hypot(left_m)),
        sums,
    }
}

/// Over all runs: places, headings.
pub(super) fn overall(runs: &[RunCompared]) -> [Rms; 2] {
    rms(&runs.iter().map(|it| &it.sums).collect::<Vec<_>>())
}

fn rms(runs: &[&Sums]) -> [Rms; 2] {
    core::array::from_fn(|i| {
        // Each run's twins have fewer measurements than itself, so they are weighed by its own.
        let count: f64 = runs.iter().map(|it| it.measured.count[i]).sum();
        let root = |of: &dyn Fn(&Sums) -> f64| {
            let sum: f64 = runs.iter().map(|it| it.measured.count[i] * of(it)).sum();
            (sum / count.max(1.0)).sqrt()
        };
        let mut twins: Vec<f64> =
            (0..DRAWS).map(|draw| root(&|it| it.drawn[draw].mean(i))).collect();
        let noise = (twins.iter().map(|it| it * it).sum::<f64>() / DRAWS as f64).sqrt();
        twins.sort_by(f64::total_cmp);
        Rms { rms: root(&|it| it.measured.mean(i)), noise, noise_high: twins[HIGH] }
    })
}

/// A track with at most [`SIGHTS_MAX`] measurements, the last among them.
fn thinned(track: &Track) -> Track {
    let count = track.measured.len();
    let every = count.div_ceil(SIGHTS_MAX).max(1);
    let kept: Vec<usize> = (0..count).filter(|k| k % every == 0 || k + 1 == count).collect();
    Track {
        measured: kept.iter().map(|k| track.measured[*k]).collect(),
        predicted: kept.iter().map(|k| track.predicted[*k]).collect(),
        step: kept.iter().map(|k| track.step[*k]).collect(),
    }
}

/// The same run as predicted, seen with made-up noise.
fn drawn(run: &PreparedRun, track: &Track, noise: &OdometryNoise, random: &mut Random) -> Track {
    let mut measurements = Vec::with_capacity(track.measured.len());
    // What dead reckoning is off by: in the fixed frame, and the heading.
    let mut off = [0.0_f64; 3];
    let mut wobble = [(); 3].map(|()| random.normal());
    let scale = [noise.position_wobble_m, noise.position_wobble_m, noise.heading_wobble_rad];
    let turned_rad = noise.heading_offset_rad * random.normal();
    let late_s = noise.clock_offset_s * random.normal();
    let mut before: Option<(Pose, usize, f64)> = None;
    for ((measurement, pose), step) in track.measured.iter().zip(&track.predicted).zip(&track.step)
    {
        if let Some((from, from_step, from_s)) = before {
            let steps = &run.motion.steps[from_step..*step];
            let rolled_m: f64 = steps.iter().map(Step::rolled_m).sum();
            let wander_rad = random.normal() * noise.heading_variance_rad2(rolled_m).sqrt();
            let lever_rad = off[2] + wander_rad / 2.0;
            let travel_sigma_m = noise.travel_variance_m2(rolled_m).sqrt();
            off[0] += -lever_rad * (pose.y_m - from.y_m) + travel_sigma_m * random.normal();
            off[1] += lever_rad * (pose.x_m - from.x_m) + travel_sigma_m * random.normal();
            off[2] += wander_rad;
            let fade = noise.wobble_fade(measurement.t_s - from_s);
            let fresh = (1.0 - fade * fade).sqrt();
            wobble = wobble.map(|it| fade * it + fresh * random.normal());
        }
        before = Some((*pose, *step, measurement.t_s));
        let white = [noise.position_sigma_m, noise.position_sigma_m, noise.heading_sigma_rad]
            .map(|sigma| sigma * random.normal());
        let of_run = {
            let (moving, (sin, cos)) = (&run.motion.steps[*step], pose.heading_rad.sin_cos());
            let behind_m = -late_s * moving.speed_mps();
            [behind_m * cos, behind_m * sin, turned_rad - late_s * moving.turn_rate_rad_s()]
        };
        let error: [f64; 3] =
            core::array::from_fn(|i| off[i] + of_run[i] + scale[i] * wobble[i] + white[i]);
        measurements.push(PoseMeasurement {
            t_s: measurement.t_s,
            position_m: measurement.position_m.map(|_| [pose.x_m + error[0], pose.y_m + error[1]]),
            heading_rad: measurement.heading_rad.map(|_| pose.heading_rad + error[2]),
        });
    }
    Track { measured: measurements, predicted: track.predicted.clone(), step: track.step.clone() }
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
                    .map(|it| start.compose(it))
                    .map(|it| [it.x_m, it.y_m])
                    .collect(),
                way_m: way(run, terms)
                    .into_iter()
                    .map(|it| start.compose(it))
                    .map(|it| [it.x_m, it.y_m])
                    .collect(),
            }
        })
        .collect()
}
