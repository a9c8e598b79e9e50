//! A few campaigns of the motors' blind benchmark, and what a user sees of one.

use beeline_tests::drivetrain::case::{Case, Kind};
use beeline_tests::drivetrain::hidden::Hidden;
use beeline_tests::drivetrain::score::judge;
use beeline_tests::parallel::in_order;

/// Seeds of their own: none is of a reported benchmark.
const SEED: u64 = 77;

#[test]
fn strong_effects_are_named_and_sound_motors_get_none() {
    let cases = [
        (Kind::Strong, vec![Hidden::LoadTorque]),
        (Kind::Strong, vec![Hidden::DirectionAsymmetry]),
        (Kind::Strong, vec![Hidden::SideAsymmetry]),
        (Kind::Nothing, Vec::new()),
    ];
    let cases: Vec<Case> = cases
        .into_iter()
        .enumerate()
        .map(|(number, (kind, hidden))| Case::with(SEED, number as u64, kind, hidden, 1.0))
        .collect();
    for score in in_order(&cases, |case| judge(SEED, case)) {
        println!("{}", score.text);
        assert_eq!(score.right, Some(true), "{}", score.text);
        assert!(!score.false_alarm, "{}", score.text);
    }
}
