//! Does `explain` find hidden effects? The whole blind benchmark: `cargo xtask bench blind`.
//!
//! ```text
//! cargo xtask bench blind [--seed S] [--campaigns N]    the whole of it; exit code 1 if a bar is missed
//!     --case I        only this case, with its answer
//!     --only KIND     only cases of one kind: strong, medium, weak, two, nothing, nuisance, outside
//!     --plant NAME    only robots of one plant: forces, kinematic
//!     --hidden EFFECT only robots that hide this effect, alone or with another one: lost_counts
//!     --hard NAME     only campaigns that are hard in one way: none, geometry, wobble, clock, ends; or all of them, each hard by
//!                     `sync` in place of its own way
//!     --keep DIR      writes the campaigns of misses there, with truth.tsv (and all of them with --keep-all)
//! ```

use host_cli::words;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use beeline_tests::blind::case::{Case, Kind, cases};
use beeline_tests::blind::hard::Hard;
use beeline_tests::blind::plant::Plant;
use beeline_tests::blind::score::{bars, confusion, ids, misses, table, too_weak};
use beeline_tests::blind::verdict::Verdict;
use beeline_tests::blind::{sim_target_robot, verdicts_on};
use host_cli::ui::Progress;

/// The seed of the reported figures; tuning uses others.
const SEED: u64 = 1;
/// Half of them hide nothing.
const CAMPAIGNS: usize = 420;

struct Arguments {
    seed: u64,
    campaigns: usize,
    case: Option<usize>,
    only: Option<Kind>,
    plant: Option<Plant>,
    hard: Option<Hard>,
    hidden: Option<String>,
    keep: Option<PathBuf>,
    keep_all: bool,
}

fn main() -> ExitCode {
    let arguments = match arguments() {
        Ok(arguments) => arguments,
        Err(why) => {
            eprintln!(
                "{why}\nusage: bench_blind [--seed S] [--campaigns N] [--case I] [--only KIND] [--plant NAME] \
                 [--hard NAME] [--hidden EFFECT] [--keep DIR] [--keep-all]"
            );
            return ExitCode::from(2);
        }
    };
    let chosen = chosen(&arguments);
    println!("{} campaigns, seed {}", chosen.len(), arguments.seed);
    let began = Instant::now();
    let progress = Progress::new("blind campaigns", false);
    let done = AtomicUsize::new(0);
    let results = verdicts_on(&chosen, &|_, _| {
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        progress.set(done as f64 / chosen.len() as f64);
    });
    drop(progress);
    let verdicts: Vec<Verdict> =
        results.iter().filter_map(|result| result.as_ref().ok()).cloned().collect();
    for (case, result) in chosen.iter().zip(&results) {
        if let Err(why) = result {
            println!("case {} ({:?}) failed: {why}", case.index, case.effects);
        }
    }
    if let Some(folder) = &arguments.keep
        && let Err(why) = keep(folder, &verdicts, arguments.keep_all)
    {
        println!("cannot keep the campaigns: {why}");
    }
    if arguments.case.is_some() {
        verdicts.iter().for_each(print_answer);
    }
    println!();
    print!("{}", confusion(&verdicts));
    println!("\nnot as they should be, by case (--case I shows one):");
    print!("{}", misses(&verdicts));
    let too_weak = too_weak(&verdicts);
    if !too_weak.is_empty() {
        println!("\ncould not be made as strong as asked for, and are not counted:");
        print!("{too_weak}");
    }
    println!();
    let bars = bars(&verdicts);
    print!("{}", table(&bars));
    print_classes_and_times(&verdicts, began.elapsed().as_secs_f64());
    let all_done = results.iter().all(Result::is_ok);
    if all_done && bars.iter().all(|bar| bar.holds()) {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// The cases that were asked for.
fn chosen(arguments: &Arguments) -> Vec<Case> {
    cases(arguments.seed, arguments.campaigns)
        .into_iter()
        .filter(|case| arguments.case.is_none_or(|index| case.index == index))
        .filter(|case| arguments.only.is_none_or(|kind| case.kind == kind))
        .filter(|case| arguments.plant.is_none_or(|plant| case.plant == plant))
        .filter_map(|case| match arguments.hard {
            Some(Hard::Sync) => Some(Case { hard: Hard::Sync, ..case }),
            hard => hard.is_none_or(|hard| case.hard == hard).then_some(case),
        })
        .filter(|case| {
            arguments
                .hidden
                .as_ref()
                .is_none_or(|id| case.effects.iter().any(|effect| effect.id() == id))
        })
        .collect()
}

/// Sizes of the classes, effects that are not there, and times.
fn print_classes_and_times(verdicts: &[Verdict], elapsed_s: f64) {
    let mut sizes: Vec<usize> = verdicts.iter().flat_map(Verdict::class_sizes).collect();
    sizes.sort_unstable();
    let alone = sizes.iter().filter(|size| **size == 1).count();
    println!(
        "classes with what is hidden: {alone} of {} name it alone, {} effects at most",
        sizes.len(),
        sizes.last().copied().unwrap_or(0)
    );
    let extra = verdicts
        .iter()
        .filter(|verdict| !verdict.case.effects.is_empty() && verdict.extra > 0)
        .count();
    let mut explain_s: Vec<f64> = verdicts.iter().map(|verdict| verdict.explain_s).collect();
    explain_s.sort_by(f64::total_cmp);
    println!(
        "{extra} campaigns with an effect were given one more that is not there; explained in {:.1} s (median), {:.1} s (longest); {:.0} s in all",
        explain_s.get(explain_s.len() / 2).copied().unwrap_or(f64::NAN),
        explain_s.last().copied().unwrap_or(f64::NAN),
        elapsed_s
    );
}

fn print_answer(verdict: &Verdict) {
    println!(
        "\ncase {}: {}, {}, {} {:?}",
        verdict.case.index,
        verdict.case.plant.name(),
        verdict.case.hard.name(),
        verdict.case.kind.name(),
        verdict.case.effects
    );
    let mm = |errors: robot_model::estimation::Errors| errors.position_rms_m * 1e3;
    println!(
        "  {:<24} cross-validated {:.3} mm",
        "nominal",
        mm(verdict.answer.baseline.cross_validated)
    );
    for step in &verdict.answer.steps {
        println!(
            "  {:<24} cross-validated {:.3} mm; {}",
            step.effect,
            mm(step.cross_validated),
            words::evidence(step)
        );
    }
    println!("  unexplained: {:?}", verdict.answer.unexplained);
    println!(
        "  cross-validated error over the truth's: {:.3}, over the noise {:.3}; floor over the noise {:.3}",
        verdict.cross_validated_ratio, verdict.over_noise, verdict.reachable_ratio
    );
    if let Some(why) = &verdict.refused {
        println!("  refused: {why}");
    }
}

/// Writes campaigns to folders, and what they hide to a file beside them.
fn keep(folder: &std::path::Path, verdicts: &[Verdict], all: bool) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|error| error.to_string())?;
    let mut truth = String::from(
        "case\tplant\thard\tkind\thidden\tgood\treached\tas_strong\theldout_ratio\tover_noise\tfloor_ratio\theldout_m\n",
    );
    for verdict in verdicts.iter().filter(|verdict| all || !verdict.good()) {
        let place = folder.join(format!("case_{:04}", verdict.case.index));
        let _ = std::fs::remove_dir_all(&place);
        sim_target_robot::keep(&verdict.campaign, &place).map_err(|error| error.to_string())?;
        truth += &format!(
            "{}\t{}\t{}\t{}\t{}\t{}\t{:.1?}\t{}\t{}\t{}\t{}\t{}\n",
            verdict.case.index,
            verdict.case.plant.name(),
            verdict.case.hard.name(),
            verdict.case.kind.name(),
            ids(verdict).join(","),
            verdict.good(),
            verdict.reached,
            verdict.as_strong_as_required(),
            verdict.cross_validated_ratio,
            verdict.over_noise,
            verdict.reachable_ratio,
            verdict
                .answer
                .steps
                .last()
                .map_or(verdict.answer.baseline.cross_validated, |step| step.cross_validated)
                .position_rms_m,
        );
    }
    std::fs::write(folder.join("truth.tsv"), truth).map_err(|error| error.to_string())
}

const KINDS: [(&str, Kind); 7] = [
    ("strong", Kind::Strong),
    ("medium", Kind::Medium),
    ("weak", Kind::Weak),
    ("two", Kind::Two),
    ("nothing", Kind::Nothing),
    ("nuisance", Kind::Nuisance),
    ("outside", Kind::Outside),
];

/// The one of this name.
fn one_of<T: Copy>(names: &[(&str, T)], name: &str) -> Result<T, String> {
    let known = names.iter().map(|entry| entry.0).collect::<Vec<_>>().join(", ");
    let found = names.iter().find(|entry| entry.0 == name);
    found.map(|entry| entry.1).ok_or(format!("no `{name}`: there are {known}"))
}

fn arguments() -> Result<Arguments, String> {
    let mut arguments = Arguments {
        seed: SEED,
        campaigns: CAMPAIGNS,
        case: None,
        only: None,
        plant: None,
        hard: None,
        hidden: None,
        keep: None,
        keep_all: false,
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} needs a value"));
        let number = |text: String| -> Result<u64, String> {
            text.parse().map_err(|_| format!("{text}: not a number"))
        };
        match word.as_str() {
            "--seed" => arguments.seed = number(value()?)?,
            "--campaigns" => arguments.campaigns = number(value()?)?.max(1) as usize,
            "--case" => arguments.case = Some(number(value()?)? as usize),
            "--keep" => arguments.keep = Some(value()?.into()),
            "--keep-all" => arguments.keep_all = true,
            "--plant" => {
                let names = Plant::BOTH.map(|plant| (plant.name(), plant));
                arguments.plant = Some(one_of(&names, &value()?)?);
            }
            "--hard" => {
                let names = Hard::ALL.map(|hard| (hard.name(), hard));
                arguments.hard = Some(one_of(&names, &value()?)?);
            }
            "--hidden" => arguments.hidden = Some(value()?),
            "--only" => arguments.only = Some(one_of(&KINDS, &value()?)?),
            _ => return Err(format!("unknown argument {word}")),
        }
    }
    Ok(arguments)
}
