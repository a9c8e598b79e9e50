//! A part of `cargo xtask bench chaos`, and that it finds what is planted.

use beeline_tests::chaos::{Plant, session};
use beeline_tests::parallel::in_order;

#[test]
fn sessions_in_which_everything_breaks_keep_every_promise() {
    let numbers: Vec<u64> = (0..60).collect();
    let ends = in_order(&numbers, |number| session(1, *number, Plant::Nothing));
    let (mut well, mut errors) = (0, 0);
    for (number, end) in numbers.iter().zip(ends) {
        let ends = end.unwrap_or_else(|what| {
            panic!("{what}: cargo xtask bench chaos --seed 1 --session {number}")
        });
        well += ends.well;
        errors += ends.error;
    }
    // Neither so bad that nothing works, nor so good that nothing fails.
    assert!(well > 60 && errors > 20, "{well} procedures ended well, {errors} with an error");
}

#[test]
fn faults_that_are_planted_are_found() {
    for (name, plant) in Plant::ALL {
        let found = (0..200).find(|number| session(1, *number, plant).is_err());
        assert!(found.is_some(), "200 sessions, and {name} was not found");
    }
}
