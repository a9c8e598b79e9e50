//! A small blind benchmark: `cargo xtask bench blind` is the whole of it.

use beeline_tests::blind::case::cases;
use beeline_tests::blind::judge_all;
use beeline_tests::blind::mystery::{Mystery, read_sealed, seal};
use beeline_tests::blind::score::{bars, misses};
use beeline_tests::blind::verdict::Verdict;

/// Not a seed that is reported, nor one that anything is tuned on.
const SEED: u64 = 20;

#[test]
fn hidden_effects_are_named_and_sound_robots_left_alone() {
    let cases = cases(SEED, 20);
    let results = judge_all(&cases, &|_, _| ());
    let verdicts: Vec<Verdict> =
        results.into_iter().map(|it| it.unwrap_or_else(|why| panic!("{why}"))).collect();
    let misses = misses(&verdicts);
    println!("{misses}");
    let bars = bars(&verdicts);
    let share = |claim: &str| {
        let bar = bars.iter().find(|it| it.claim.starts_with(claim)).unwrap();
        (bar.measured, bar.of)
    };
    // Twenty campaigns cannot measure a share of a few percent: were the robot-model at its bars, these bounds
    // would be broken by chance in one benchmark of a hundred.
    let (named, of) = share("one effect, medium and strong"); // bar 0.95
    assert!(of >= 3 && named * of as f64 >= of as f64 - 1.0, "{named} of {of}: {misses}");
    let (alarms, of) = share("nothing"); // bar 0.05
    assert!(of >= 8 && alarms * of as f64 <= 2.0, "{alarms} of {of}: {misses}");
    let ratio = bars.iter().find(|it| it.ratio).unwrap(); // bar 1.15
    // Two-sided: far better than the fit that knows the truth would be a judge that cheats.
    assert!((0.5..1.15).contains(&ratio.measured), "{ratio:?}: {misses}");
}

#[test]
fn the_mystery_robots_seal_holds_and_its_secret_is_found() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/mystery-robot");
    let text = std::fs::read_to_string(folder.join("answer.toml.sealed")).unwrap();
    let (seed, sha256) = read_sealed(&text).unwrap();
    // A change of the catalogue's order or of what is drawn breaks the seal: then record it anew.
    let mystery = Mystery::draw(seed);
    assert_eq!(seal(&mystery.answer()), sha256);

    // What the README shows of the opened seal.
    let readme = std::fs::read_to_string(folder.join("../../README.md")).unwrap();
    for words in [mystery.answer(), sha256] {
        assert!(readme.contains(&words), "README.md is to show:\n{words}");
    }

    let campaign = host_cli::campaign::Campaign::read(&folder).unwrap();
    let answer = robot_model::explain::explain(&campaign.to_model(&folder).unwrap()).unwrap();
    let first = &answer.steps[0];
    assert!(first.class.iter().any(|it| it == mystery.hidden()), "{:?}", first.class);
    assert!(first.heldout.position_rms_m < answer.baseline.heldout.position_rms_m);
}
