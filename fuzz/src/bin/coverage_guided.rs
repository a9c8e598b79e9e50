//! One target under libFuzzer, which searches for inputs that reach new code: `cargo xtask fuzz TARGET`.
//!
//! `BEELINE_FUZZ_TARGET` names it: one program for all of them is compiled once. Without that variable it lists
//! them, a line each: name, longest input, dictionary.
#![no_main]

use std::sync::LazyLock;

use beeline_fuzz::target::{TARGETS, Target};
use libfuzzer_sys::fuzz_target;

const VARIABLE: &str = "BEELINE_FUZZ_TARGET";

static TARGET: LazyLock<&Target> = LazyLock::new(|| {
    let Ok(name) = std::env::var(VARIABLE) else {
        for target in TARGETS {
            println!("{} {} {}", target.name, target.len_max, target.dictionary.unwrap_or("-"));
        }
        std::process::exit(0);
    };
    Target::named(&name).unwrap_or_else(|| panic!("{VARIABLE}: no target `{name}`"))
});

fuzz_target!(
    init: {
        LazyLock::force(&TARGET);
    },
    |input: &[u8]| TARGET.run(input)
);
