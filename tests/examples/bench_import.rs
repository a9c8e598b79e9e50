//! Does a campaign that went through a bag give the same answer? `cargo xtask bench import`.
//!
//! ```text
//! cargo xtask bench import [--seed S] [--campaigns N] [--case I] [--keep DIR]
//! ```
//!
//! Campaigns of the blind benchmark are written as one long bag each, joints and poses by the tracker's axes, with the robot carried
//! between its runs. The bag is cut and imported without hints beyond the data sheet, and explained. The answer is the same if every
//! effect that matters in one of both answers is named in the other, alone or with others that the runs cannot tell from it.
//!
//! Left out is what a bag cannot carry: the load of a run, and poses at both ends alone, by which no clock is found. The exit code is 1 if
//! fewer than 95 % are the same.

#[allow(dead_code, reason = "the bag is one of several logs that it makes")]
#[path = "../../import/tests/round_trip/one_log.rs"]
mod one_log;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};

use beeline_tests::blind::case::{Case, cases};
use beeline_tests::blind::hard::Hard;
use beeline_tests::blind::verdict::verdict_on;
use beeline_tests::parallel::in_order;
use campaign::Campaign;
use host_cli::ui::Progress;
use import::source::{Choice, Sources};
use import::understand::{Hints, understand};
use one_log::OneLog;
use robot_model::explain::{Answer, explain};

/// The share that must be the same.
const SAME_MIN: f64 = 0.95;

struct Arguments {
    seed: u64,
    campaigns: usize,
    case: Option<usize>,
    keep: Option<PathBuf>,
}

/// Both answers to one case.
struct Both {
    direct: Answer,
    imported: Result<Answer, String>,
}

fn main() -> ExitCode {
    let arguments = match arguments() {
        Ok(arguments) => arguments,
        Err(why) => {
            eprintln!(
                "{why}\nusage: bench_import [--seed S] [--campaigns N] [--case I] [--keep DIR]"
            );
            return ExitCode::from(2);
        }
    };
    // One in six has poses at its ends alone, and some carry loads.
    let chosen: Vec<Case> = cases(arguments.seed, 2 * arguments.campaigns)
        .into_iter()
        .filter(|case| case.hard != Hard::Ends)
        .filter(|case| case.effects.iter().all(|effect| effect.id() != "payload"))
        .take(arguments.campaigns)
        .filter(|case| arguments.case.is_none_or(|index| case.index == index))
        .collect();
    println!("{} campaigns, seed {}", chosen.len(), arguments.seed);
    let progress = Progress::new("bags", false);
    let done = AtomicUsize::new(0);
    let results = in_order(&chosen, |case| {
        let both = both(case, arguments.keep.as_deref());
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        progress.set(done as f64 / chosen.len() as f64);
        both
    });
    drop(progress);
    let mut same = 0;
    for (case, result) in chosen.iter().zip(&results) {
        let (is_same, words) = match result {
            Ok(both) => compared(both),
            Err(why) => (false, format!("not recorded: {why}")),
        };
        same += usize::from(is_same);
        if !is_same || arguments.case.is_some() {
            let hidden: Vec<&str> = case.effects.iter().map(|effect| effect.id()).collect();
            println!("case {} ({}, {}): {words}", case.index, case.hard.name(), hidden.join(", "));
        }
    }
    let share = same as f64 / chosen.len().max(1) as f64;
    println!("the same answer: {same} of {} ({:.0} %)", chosen.len(), 100.0 * share);
    if share >= SAME_MIN { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Explains a case as it was recorded, and as it comes out of a bag.
fn both(case: &Case, keep: Option<&Path>) -> Result<Both, String> {
    let verdict = verdict_on(case)?;
    if let Some(why) = verdict.refused {
        return Err(why);
    }
    let place = tempfile::tempdir().map_err(|error| error.to_string())?;
    let kept = keep.map(|folder| folder.join(format!("case_{:04}", case.index)));
    let place = kept.as_deref().unwrap_or(place.path());
    std::fs::create_dir_all(place).map_err(|error| error.to_string())?;
    let imported = through_a_bag(&verdict.campaign, place);
    Ok(Both { direct: verdict.answer, imported })
}

/// Writes a campaign as a bag, imports it, and explains it.
fn through_a_bag(campaign: &Campaign, place: &Path) -> Result<Answer, String> {
    let bag = place.join("drive.mcap");
    let log = OneLog::of_campaign(campaign, 0.0, 0..usize::MAX);
    std::fs::write(&bag, log.bag()).map_err(|error| error.to_string())?;
    let folder = place.join("imported");
    let sheet = Hints {
        wheel_radius_m: Some(campaign.robot.wheel_radius_m),
        track_width_m: Some(campaign.robot.track_width_m),
        ..Hints::default()
    };
    let written = Sources::open(&[bag], &[]).and_then(|sources| {
        let chosen = sources.choose(&Choice::default())?;
        let understood = understand(chosen.wheels, &chosen.poses, &sheet, chosen.same_clock)?;
        import::write::write(&understood, &folder, false)
    });
    written.map_err(|error| error.to_string())?;
    let read = Campaign::read_both(&folder)
        .and_then(|(read, recordings)| recordings.into_model(&read, &folder));
    let model = read.map_err(|error| error.to_string())?;
    explain(&model).map_err(|error| error.to_string())
}

/// Whether both answers are the same, and what they say.
fn compared(both: &Both) -> (bool, String) {
    let said = |answer: &Answer| {
        let each = answer.steps.iter().filter(|step| step.matters).map(|step| step.class.join("|"));
        let mut words = each.collect::<Vec<_>>().join(", ");
        if answer.unexplained.structure {
            words += " and something unexplained";
        }
        words
    };
    let imported = match &both.imported {
        Ok(imported) => imported,
        Err(why) => return (false, format!("{} -> {why}", said(&both.direct))),
    };
    let named = |one: &Answer, other: &Answer| {
        one.steps.iter().filter(|step| step.matters).all(|step| {
            other.steps.iter().any(|there| there.class.iter().any(|id| step.class.contains(id)))
        })
    };
    let same = named(&both.direct, imported) && named(imported, &both.direct);
    (same, format!("{} -> {}", said(&both.direct), said(imported)))
}

fn arguments() -> Result<Arguments, String> {
    let mut arguments = Arguments { seed: 1, campaigns: 50, case: None, keep: None };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let value = words.next().ok_or(format!("{word} needs a value"))?;
        let number = || value.parse::<u64>().map_err(|_| format!("{value}: not a number"));
        match word.as_str() {
            "--seed" => arguments.seed = number()?,
            "--campaigns" => arguments.campaigns = number()?.max(1) as usize,
            "--case" => arguments.case = Some(number()? as usize),
            "--keep" => arguments.keep = Some(value.into()),
            _ => return Err(format!("unknown argument {word}")),
        }
    }
    Ok(arguments)
}
