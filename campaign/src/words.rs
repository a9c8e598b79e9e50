//! Why a recording cannot be used, in words.

use robot_model::recording::{RecordingError, RecordingProblem};

/// What is wrong with a recording.
pub const fn recording_problem(problem: RecordingProblem) -> &'static str {
    match problem {
        RecordingProblem::NoRuns => "the campaign has no runs",
        RecordingProblem::AllHeldOut => "all runs are held out, so none is left to fit",
        RecordingProblem::TooFewSamples => "fewer than two samples of the encoders",
        RecordingProblem::NotFinite => "a number that is not finite",
        RecordingProblem::TimeNotIncreasing => "time does not increase",
    }
}

/// The same with its run, where it is about one.
pub fn recording_error(error: &RecordingError) -> String {
    let problem = recording_problem(error.problem);
    match error.problem {
        RecordingProblem::NoRuns | RecordingProblem::AllHeldOut => problem.to_owned(),
        RecordingProblem::TooFewSamples
        | RecordingProblem::NotFinite
        | RecordingProblem::TimeNotIncreasing => format!("run {}: {problem}", error.run),
    }
}
