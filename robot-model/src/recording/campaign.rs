//! All runs of one robot, prepared once for every question that follows.

use serde::Serialize;

use crate::recording::condense::{WheelSamples, condensed, poses_within_s};
use crate::recording::excitation::Excitation;
use crate::recording::motion::Motion;
use crate::recording::odometry_noise::OdometryNoise;
use crate::recording::repetitions::repetitions;
use crate::recording::run::{Recording, RecordingError, RecordingProblem, Robot};
use crate::recording::run_kind::{RunKind, kind_of};

/// Recorded runs of one robot.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Campaign {
    /// The nominal robot.
    pub robot: Robot,
    /// The runs, in the order in which they were made.
    pub runs: Vec<Recording>,
}

/// A run, with its motion worked out.
#[derive(Clone, Debug)]
pub(crate) struct PreparedRun {
    pub recording: Recording,
    pub motion: Motion,
    pub kind: RunKind,
}

/// A campaign, with what does not depend on any model.
#[derive(Clone, Debug)]
pub(crate) struct Prepared {
    pub robot: Robot,
    /// The runs that models are fitted to.
    pub runs: Vec<PreparedRun>,
    /// The runs held out, which only show what a model predicts.
    pub held_out: Vec<PreparedRun>,
    /// Of the runs that are fitted to.
    pub excitation: Excitation,
    /// The runs that models are fitted to as they were recorded, where `runs` are lighter; errors are those of these.
    pub dense: Option<Vec<PreparedRun>>,
    /// How many measured poses became one in `runs`, in the mean.
    pub poses_in_one: f64,
    /// The noise, if it is not to be learnt from the residuals of a model.
    pub noise: Option<OdometryNoise>,
}

impl Prepared {
    /// The runs as they were recorded.
    pub fn recorded(&self) -> &[PreparedRun] {
        self.dense.as_deref().unwrap_or(&self.runs)
    }
}

impl Campaign {
    /// The runs that a model is fitted to: all but those held out.
    pub fn fitted_runs(&self) -> impl Iterator<Item = &Recording> {
        self.runs.iter().filter(|run| !run.held_out)
    }

    /// The number of the motion of each of these: runs with the same number repeat one another.
    pub fn motions(&self) -> Vec<usize> {
        repetitions(&self.robot, self.fitted_runs())
    }

    /// Works out each run's motion, and separates the runs held out.
    pub(crate) fn prepare(&self) -> Result<Prepared, RecordingError> {
        for run in &self.runs {
            run.validate()?;
        }
        if let (Some(first), None) = (self.runs.first(), self.fitted_runs().next()) {
            let problem = RecordingProblem::AllHeldOut;
            return Err(RecordingError { run: first.name.clone(), problem });
        }
        let began_s = began_s(self.fitted_runs());
        let prepared = |recording: &Recording| {
            let clock_s = began_s.zip(recording.started_s).map(|(first, own_s)| own_s - first);
            let motion = Motion::new(&self.robot, recording, clock_s);
            let kind = kind_of(&motion);
            PreparedRun { recording: recording.clone(), motion, kind }
        };
        let runs: Vec<PreparedRun> = self.fitted_runs().map(&prepared).collect();
        let held_out = self.runs.iter().filter(|run| run.held_out).map(prepared).collect();
        let excitation = self.excitation(&runs, began_s);
        Ok(Prepared {
            robot: self.robot,
            runs,
            held_out,
            excitation,
            dense: None,
            poses_in_one: 1.0,
            noise: None,
        })
    }

    /// The same, with lighter runs where they were recorded densely.
    pub(crate) fn prepare_lighter(
        &self,
        samples: WheelSamples,
    ) -> Result<Prepared, RecordingError> {
        let dense = self.prepare()?;
        let how = (samples, poses_within_s(self.fitted_runs(), samples));
        let lighter = |run: &PreparedRun| condensed(&self.robot, &run.recording, how);
        let light: Vec<(Recording, f64)> = dense.runs.iter().map(lighter).collect();
        let same = |(run, (lighter, _)): (&PreparedRun, &(Recording, f64))| {
            run.recording.wheels == lighter.wheels
                && run.recording.measured_poses.len() == lighter.measured_poses.len()
        };
        if dense.runs.iter().zip(&light).all(same) {
            return Ok(dense);
        }
        let poses_in_one =
            light.iter().map(|(_, many)| many).sum::<f64>() / light.len().max(1) as f64;
        let runs = dense
            .runs
            .iter()
            .zip(light)
            .map(|(run, (recording, _))| {
                let clock_s = run.motion.steps.first().map(|step| step.clock_s - step.t_s);
                let clock_s = clock_s.filter(|_| run.recording.started_s.is_some());
                let motion = Motion::new(&self.robot, &recording, clock_s);
                PreparedRun { recording, motion, kind: run.kind }
            })
            .collect();
        let mut robot = self.robot;
        let averaged = |sigma: Option<f64>| sigma.map(|sigma| sigma / poses_in_one.sqrt());
        robot.position_sigma_m = averaged(robot.position_sigma_m);
        robot.heading_sigma_rad = averaged(robot.heading_sigma_rad);
        Ok(Prepared { robot, runs, dense: Some(dense.runs), poses_in_one, ..dense })
    }

    fn excitation(&self, runs: &[PreparedRun], began_s: Option<f64>) -> Excitation {
        let mut excitation = Excitation::default();
        for run in runs {
            let started_s = began_s.zip(run.recording.started_s);
            let clock_s = started_s.map_or(0.0, |(first, own_s)| own_s - first);
            let path_m: f64 = run.motion.steps.iter().map(|step| step.travel_m().abs()).sum();
            excitation.path_max_m = excitation.path_max_m.max(path_m);
            excitation.span_s = excitation.span_s.max(clock_s + run.recording.duration_s());
            for step in &run.motion.steps {
                let speed_mps = step.wheel_speed_mps.map(f64::abs);
                let rate_rad_s = speed_mps.left.max(speed_mps.right) / self.robot.wheel_radius_m;
                excitation.wheel_rate_max_rad_s = excitation.wheel_rate_max_rad_s.max(rate_rad_s);
            }
        }
        excitation
    }
}

/// When the first of these runs began \[s\].
///
/// `None` unless every run has a start time: the order in which files happen to be listed tells nothing.
fn began_s<'a>(runs: impl Iterator<Item = &'a Recording>) -> Option<f64> {
    let starts: Vec<f64> = runs.map(|run| run.started_s).collect::<Option<_>>()?;
    starts.into_iter().reduce(f64::min)
}
