//! One target under libFuzzer, which searches for inputs that reach new code: `cargo xtask fuzz TARGET`.
//!
//! `BEELINE_FUZZ_TARGET` names it: one program for all of them is compiled once.
#![no_main]

use std::sync::LazyLock;

use beeline_fuzz::target::Target;
use libfuzzer_sys::fuzz_target;

static TARGET: LazyLock<&Target> = LazyLock::new(|| {
    let name = std::env::var("BEELINE_FUZZ_TARGET").unwrap_or_default();
    Target::named(&name).unwrap_or_else(|| panic!("BEELINE_FUZZ_TARGET: no target `{name}`"))
});

fuzz_target!(|input: &[u8]| TARGET.run(input));
