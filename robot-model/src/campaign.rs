//! All runs of one robot, prepared once for everything that looks at them.

use crate::effect::Survey;
use crate::motion::Motion;
use crate::recording::{Recording, RecordingError, Robot};
use crate::run_kind::{RunKind, kind_of};

/// Recorded runs of one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Campaign {
    /// The robot, as nominal.
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
    pub runs: Vec<PreparedRun>,
    pub survey: Survey,
}

impl Campaign {
    pub(crate) fn prepare(&self) -> Result<Prepared, RecordingError> {
        for run in &self.runs {
            run.validate()?;
        }
        let clocks = clocks_s(&self.runs);
        let runs: Vec<PreparedRun> = self
            .runs
            .iter()
            .enumerate()
            .map(|(index, recording)| {
                let clock_s = clocks.as_ref().map(|it| it[index]);
                let motion = Motion::new(&self.robot, recording, clock_s);
                let kind = kind_of(&motion);
                PreparedRun { recording: recording.clone(), motion, kind }
            })
            .collect();
        let mut survey = Survey::default();
        for (index, run) in runs.iter().enumerate() {
            let clock_s = clocks.as_ref().map_or(0.0, |it| it[index]);
            let path_m: f64 = run.motion.steps.iter().map(|it| it.travel_m().abs()).sum();
            survey.path_max_m = survey.path_max_m.max(path_m);
            survey.span_s = survey.span_s.max(clock_s + run.recording.duration_s());
            for step in &run.motion.steps {
                let speed_mps = step.wheel_speed_mps.map(f64::abs);
                let rate_rad_s = speed_mps.left.max(speed_mps.right) / self.robot.wheel_radius_m;
                survey.wheel_rate_max_rad_s = survey.wheel_rate_max_rad_s.max(rate_rad_s);
            }
        }
        Ok(Prepared { robot: self.robot, runs, survey })
    }
}

/// When each run began, from the campaign's first moment \[s\].
///
/// `None` where not every run says so: nothing is read from the order in which files happen to be listed.
fn clocks_s(runs: &[Recording]) -> Option<Vec<f64>> {
    let told: Vec<f64> = runs.iter().map(|run| run.started_s).collect::<Option<_>>()?;
    let first = told.iter().copied().fold(f64::INFINITY, f64::min);
    Some(told.into_iter().map(|it| it - first).collect())
}
