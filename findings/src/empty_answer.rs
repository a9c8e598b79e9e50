//! An answer in which nothing is found, and a step of one. Each test changes the part that it is about.

use robot_model::estimation::{ErrorPair, Errors};
use robot_model::explain::{Answer, Evidence, StepFound};
use robot_model::recording::OdometryNoise;
use robot_model::residuals::Unexplained;

/// Nothing is known, found, rejected or held out, and all errors are zero.
pub fn nothing_found() -> Answer {
    Answer {
        known: Vec::new(),
        baseline: ErrorPair { fitted: Errors::default(), cross_validated: Errors::default() },
        steps: Vec::new(),
        fitted_along: Vec::new(),
        rejected: Vec::new(),
        unexplained: Unexplained { p_value: 0.5, ..Unexplained::default() },
        next_run: None,
        held_out: None,
        reachable: Errors::default(),
        clocks: Vec::new(),
        alternative_fit: None,
        tolerance_m: 1e-4,
        predicts_with: Vec::new(),
        predicts_by: ErrorPair { fitted: Errors::default(), cross_validated: Errors::default() },
        noise: OdometryNoise::TYPICAL,
        compared_by: OdometryNoise::TYPICAL,
        set_aside: None,
    }
}

/// A step that matters, by the first of these effects, which the runs cannot tell from the others; all errors are zero.
pub fn step_of(class: &[&str]) -> StepFound {
    StepFound {
        effect: class[0].into(),
        class: class.iter().map(|id| (*id).to_owned()).collect(),
        parameters: Vec::new(),
        fitted: Errors::default(),
        cross_validated: Errors::default(),
        p_value: 1e-9,
        evidence: Evidence::default(),
        effect_size_m: 1e-2,
        least_size_m: 1e-2,
        moves_no_track: false,
        nears_runs: true,
        used_to_predict: true,
        matters: true,
    }
}
