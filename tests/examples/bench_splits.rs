//! Fitted to some runs, how well are the others predicted? `cargo xtask bench splits FOLDER [OTHER_FOLDER] [--by-name]`.
//!
//! The runs of a recorded campaign are divided by kind, by halves and every other one; those of two campaigns, from each to the
//! other. What `explain` chooses is held against R_L, R_R and b alone. Kinds are what the motion shows, or with `--by-name` the
//! names of runs up to their first digit. Never worse by more than 2 %, and better in a third: else the bench fails.

use std::path::Path;
use std::process::ExitCode;

use beeline_tests::parallel::in_order;
use campaign::Campaign as Files;
use robot_model::effect::{Effect, find};
use robot_model::explain::explain;
use robot_model::explain::model::fit;
use robot_model::recording::{Campaign, Recording, RecordingError, RunKind};

/// What a person would calibrate.
const THREE: [&str; 3] = ["wheel_radius_ratio", "wheel_radius_scale", "track_width"];

/// Errors that differ by less than this share are the same.
const SAME: f64 = 0.02;

/// Runs to fit to, and runs to predict.
struct Split {
    name: String,
    fitted: Campaign,
    predicted: Campaign,
}

fn main() -> ExitCode {
    let (flags, folders): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|word| word.starts_with("--"));
    let by_name = flags.iter().any(|flag| flag == "--by-name");
    if folders.is_empty() || folders.len() > 2 || flags.len() > usize::from(by_name) {
        eprintln!("usage: bench_splits FOLDER [OTHER_FOLDER] [--by-name]");
        return ExitCode::from(2);
    }
    let read = |folder: &String| read(Path::new(folder));
    let campaigns = match folders.iter().map(read).collect::<Result<Vec<Campaign>, _>>() {
        Ok(campaigns) => campaigns,
        Err(problem) => {
            eprintln!("{problem}");
            return ExitCode::from(2);
        }
    };
    let splits = match &campaigns[..] {
        [one] => within(one, by_name),
        [one, other] => vec![split("first folder", one, other), split("other folder", other, one)],
        _ => Vec::new(),
    };
    let errors = in_order(&splits, errors_m);
    let (mut better, mut worse) = (0, 0);
    println!("{:<44} {:>11} {:>10}", "fitted to", "R_L, R_R, b", "explain");
    for (split, errors) in splits.iter().zip(&errors) {
        let (three_m, chosen_m) = match errors {
            Ok(errors) => errors,
            Err(problem) => {
                println!("{:<44} {problem}", split.name);
                continue;
            }
        };
        let verdict = match chosen_m / three_m {
            ratio if ratio > 1.0 + SAME => "WORSE",
            ratio if ratio < 1.0 - SAME => "better",
            _ => "the same",
        };
        better += usize::from(verdict == "better");
        worse += usize::from(verdict == "WORSE");
        let (three_mm, chosen_mm) = (1e3 * three_m, 1e3 * chosen_m);
        println!("{:<44} {three_mm:>8.1} mm {chosen_mm:>7.1} mm  {verdict}", split.name);
    }
    println!("of {} splits {better} are better, {worse} worse", splits.len());
    if worse == 0 && 3 * better >= splits.len() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn read(folder: &Path) -> Result<Campaign, campaign::CampaignError> {
    let (files, recordings) = Files::read_both(folder)?;
    recordings.into_model(&files, folder)
}

/// All splits of one campaign.
fn within(campaign: &Campaign, by_name: bool) -> Vec<Split> {
    let kind = |run: &Recording| match by_name {
        true => run.name.split(|letter: char| letter.is_ascii_digit()).next().map(str::to_owned),
        false => RunKind::of(&campaign.robot, run).ok().map(|kind| kind.name().to_owned()),
    };
    let kinds: Vec<String> =
        campaign.runs.iter().map(|run| kind(run).unwrap_or_default()).collect();
    let mut all: Vec<&String> = kinds.iter().collect();
    all.sort();
    all.dedup();
    let some = |wanted: &dyn Fn(usize) -> bool| {
        let runs = campaign.runs.iter().enumerate().filter(|(index, _)| wanted(*index));
        Campaign { runs: runs.map(|(_, run)| run.clone()).collect(), ..campaign.clone() }
    };
    let mut splits = Vec::new();
    let mut both = |names: [String; 2], is_one: &dyn Fn(usize) -> bool| {
        let (one, other) = (some(is_one), some(&|index| !is_one(index)));
        if !one.runs.is_empty() && !other.runs.is_empty() {
            let [name, opposite] = names;
            splits.push(split(&name, &one, &other));
            splits.push(split(&opposite, &other, &one));
        }
    };
    for kind in all {
        let label = kind.trim_end_matches('_');
        both([format!("{label} only"), format!("all but {label}")], &|index| kinds[index] == *kind);
    }
    let half = campaign.runs.len() / 2;
    both(["the first half", "the second half"].map(str::to_owned), &|index| index < half);
    both(["every other run", "the others"].map(str::to_owned), &|index| index % 2 == 0);
    splits
}

fn split(name: &str, fitted: &Campaign, predicted: &Campaign) -> Split {
    let (of, others) = (fitted.runs.len(), predicted.runs.len());
    let name = format!("{name} ({of} runs, {others} predicted)");
    Split { name, fitted: fitted.clone(), predicted: predicted.clone() }
}

/// Position errors of the predicted runs \[m\]: by the three numbers, and by what `explain` chooses.
fn errors_m(split: &Split) -> Result<(f64, f64), RecordingError> {
    let three: Vec<&dyn Effect> = THREE.iter().filter_map(|id| find(id)).collect();
    let by_three = fit(&split.fitted, &three)?.errors_on(&split.predicted)?;
    let by_explain = explain(&split.fitted)?.errors_on(&split.predicted)?;
    Ok((by_three.position_rms_m, by_explain.position_rms_m))
}
