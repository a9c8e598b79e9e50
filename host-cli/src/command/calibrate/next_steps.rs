//! What a user can do after a calibration. Never suggests what was just done.

use robot_model::calibration::Source;

use crate::calibrate::Outcome;
use crate::calibration_page::Basis;
use crate::cli::{CalibrateArgs, Common, Measure};
use crate::dialogue;
use crate::port::Port;
use crate::ui::{DIM, paint, say};
use crate::words;

/// The seed that is suggested, and the one for a user who has just used it.
const OTHER_SEEDS: [u64; 2] = [7, 8];

/// Says what would make W_T more certain, one suggestion a line.
pub(super) fn advise(outcome: &Outcome) {
    if outcome.basis != Basis::OneRun {
        // The advice is about a single run.
        say(format_args!("           {}", outcome.basis));
        return;
    }
    for suggestion in words::advice(&outcome.before.wheel_weight.advice).split("; ") {
        say(format_args!("           {suggestion}"));
    }
    if outcome.before.wheel_weight.advice.dominating == Source::Wander {
        say("           beeline calibrate --runs 4 does that");
    }
}

/// What to try after a measurement that cannot tell whether W_T is wrong.
pub(super) fn after_cannot_tell(args: &CalibrateArgs, outcome: &Outcome) -> String {
    let weight = &outcome.before.wheel_weight;
    match outcome.basis {
        Basis::OneRun => words::advice(&weight.advice),
        Basis::Mean(runs) if runs < 50 => format!(
            "more runs, --runs {}, or longer ones, --distance; the {} contributes most to the uncertainty",
            2 * runs,
            words::source(weight.advice.dominating)
        ),
        Basis::Mean(_) | Basis::BothWays => format!(
            "drive farther than the {} of --distance, or measure better: the {} contributes most to the uncertainty of a run",
            args.distance,
            words::source(weight.advice.dominating)
        ),
    }
}

/// What to try after a new W_T that made the robot no straighter.
pub(super) fn after_no_better(args: &CalibrateArgs) -> &'static str {
    match (args.out_and_back, args.runs) {
        (false, None | Some(1)) => {
            "is the alignment at the start good enough? --out-and-back tells a pull from unequal radii"
        }
        (false, Some(_)) => {
            "is something else bending the path? --out-and-back tells a pull from unequal radii"
        }
        (true, _) => {
            "is the alignment at the start good enough? --runs 4 takes the mean of four runs"
        }
    }
}

/// Suggests commands after a successful calibration.
pub(super) fn say_steps(common: &Common, args: &CalibrateArgs) {
    if dialogue::current().is_some() {
        // A page has buttons for them.
        return;
    }
    let steps = match common.port {
        Port::Sim(_) => on_simulator(common, args),
        _ => vec![
            (format!("drive straight 8rev --port {}", common.port), "look along the line"),
            (format!("calibrate --undo --port {}", common.port), "restore the old W_T"),
        ],
    };
    let width = steps.iter().map(|(command, _)| command.len()).max().unwrap_or(0);
    say("");
    say("What to try next:");
    for (command, why) in steps {
        say(format_args!("  beeline {command:<width$}   {}", paint(DIM, why)));
    }
}

fn on_simulator(common: &Common, args: &CalibrateArgs) -> Vec<(String, &'static str)> {
    let scenario = match &common.port {
        Port::Sim(Some(_)) => format!(" --port {}", common.port),
        _ => String::new(),
    };
    let again = |options: &str| format!("calibrate {options}{scenario}");
    let seed = OTHER_SEEDS.into_iter().find(|seed| common.seed != Some(*seed)).unwrap_or_default();
    let other = match args.measure {
        None | Some(Measure::Camera) => (
            again(&format!("--seed {seed} --measure ruler")),
            "other noise, and a ruler instead of the camera",
        ),
        _ => (again(&format!("--seed {seed} --measure camera")), "other noise, and the camera"),
    };
    let first = match &common.flash {
        // A robot with a flash drives straight now: measuring it again would only confirm that.
        Some(flash) => (
            format!("calibrate --undo --flash {}{scenario}", flash.display()),
            "restore the old W_T",
        ),
        None => other,
    };
    let second = if args.out_and_back {
        (again("--runs 4"), "the mean of four runs")
    } else {
        (again("--out-and-back"), "is it the radius at all?")
    };
    vec![first, second, ("calibrate --port /dev/ttyACM0".into(), "a real one")]
}
