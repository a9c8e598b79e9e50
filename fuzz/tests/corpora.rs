//! Every target on its corpus, and on what random changes make of it: the part of fuzzing that runs everywhere.
//!
//! One seed draws all changes, so a failure comes again. A failing input is kept in the build folder and named.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;

use beeline_fuzz::corpus;
use beeline_fuzz::target::{TARGETS, Target};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Unless `BEELINE_FUZZ_SEED` is another one.
const SEED: u64 = 16;

/// Changed inputs for each target, unless `BEELINE_FUZZ_CHANGES` says how many. Those that simulate a robot take a thousand
/// times as long as the others, and bags ten times.
fn changed(target: &Target) -> usize {
    let by_hand = std::env::var("BEELINE_FUZZ_CHANGES").ok().map(|count| count.parse());
    match by_hand {
        Some(count) => count.expect("BEELINE_FUZZ_CHANGES is a number"),
        None if matches!(target.name, "robot" | "scenario") => 40,
        // Each is written to a file, and may become a campaign.
        None if target.name == "bag" => 2000,
        None => 4000,
    }
}

/// The inputs of a corpus, in the order of their names.
fn inputs(target: &str) -> Vec<Vec<u8>> {
    let folder = corpus(target);
    let entries = fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.iter().map(|file| fs::read(file).unwrap()).collect()
}

/// Runs an input; if it fails, keeps it in a file and says where.
fn run(target: &Target, input: &[u8]) {
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| target.run(input))) {
        let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("fails_{}", target.name));
        fs::write(&file, input).unwrap();
        eprintln!("{}: the input that fails is kept in {}", target.name, file.display());
        resume_unwind(panic);
    }
}

fn change(input: &mut Vec<u8>, all: &[Vec<u8>], random: &mut ChaCha8Rng) {
    let at = random.random_range(0..=input.len());
    let end = (at + random.random_range(0..16)).min(input.len());
    match random.random_range(0..6) {
        0 if at < input.len() => input[at] ^= 1 << random.random_range(0..8),
        1 => drop(input.drain(at..end)),
        2 => input.insert(at, random.random()),
        3 => {
            let again = input[at..end].to_vec();
            input.splice(at..at, again);
        }
        4 => {
            // A piece of another input.
            let other = &all[random.random_range(0..all.len())];
            let from = random.random_range(0..=other.len());
            let to = (from + random.random_range(0..64)).min(other.len());
            input.splice(at..end, other[from..to].iter().copied());
        }
        _ => {
            const NUMBERS: [&str; 8] =
                ["0", "-1", "1e308", "-1e-308", "nan", "inf", "1e-7", "65536"];
            let number = NUMBERS[random.random_range(0..NUMBERS.len())];
            input.splice(at..end, number.bytes());
        }
    }
}

fn replay(target: &Target) {
    let all = inputs(target.name);
    assert!(!all.is_empty(), "{} has no corpus", target.name);
    all.iter().for_each(|input| run(target, input));
    let by_hand = std::env::var("BEELINE_FUZZ_SEED").ok();
    let seed = by_hand.map_or(SEED, |seed| seed.parse().expect("BEELINE_FUZZ_SEED is a number"));
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for _ in 0..changed(target) {
        let mut input = all[random.random_range(0..all.len())].clone();
        for _ in 0..random.random_range(1..5) {
            change(&mut input, &all, &mut random);
        }
        input.truncate(target.len_max);
        run(target, &input);
    }
}

/// libFuzzer refuses a dictionary with anything but a quoted word in printable ASCII on each line.
#[test]
fn every_dictionary_can_be_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("dictionary");
    for name in TARGETS.iter().filter_map(|target| target.dictionary) {
        let file = folder.join(name).with_extension("dict");
        let bytes = fs::read(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        for (number, line) in bytes.split(|byte| *byte == b'\n').enumerate() {
            let quoted = line.len() >= 3 && line.starts_with(b"\"") && line.ends_with(b"\"");
            let comment = line.is_empty() || line.starts_with(b"#");
            let printable = line.iter().all(|byte| (b' '..=b'~').contains(byte));
            assert!(printable && (quoted || comment), "{}:{}", file.display(), number + 1);
        }
    }
}

macro_rules! replay {
    ($($name:ident)*) => {$(
        #[test]
        fn $name() {
            replay(Target::named(stringify!($name)).expect("there is such a target"));
        }
    )*

        #[test]
        fn every_target_is_run_and_every_corpus_has_its_target() {
            let run = [$(stringify!($name)),*];
            assert_eq!(TARGETS.iter().map(|target| target.name).collect::<Vec<_>>(), run);
            let folders = fs::read_dir(corpus("")).unwrap().map(|entry| entry.unwrap().file_name());
            let mut folders: Vec<_> = folders.map(|name| name.into_string().unwrap()).collect();
            folders.sort();
            let mut names = run.map(String::from);
            names.sort();
            assert_eq!(folders, names);
        }
    };
}

replay! {
    frames messages robot robot_toml run_csv model_toml motors_toml plan_toml expression motor_expression scenario track gyro config_set config_file
    quantity bag log_table wpilog controller_yaml
}
