//! Fuzz targets: each takes any bytes as an input from outside, and panics if something does not hold that must.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`target`] | the targets, one table |
//! | [`memory`] | how much memory an input takes |
//! | [`bytes`] | an input taken apart |
//!
//! `cargo test -p beeline-fuzz` runs every target on its corpus, `fuzz/corpus/TARGET/`, and on what comes of it by
//! random changes from one seed; `cargo xtask fuzz TARGET` searches for inputs that reach new code, with libFuzzer.
//!
//! A target panics for a bug only: an input that is refused with an error is a good end.

pub mod bytes;
pub mod memory;
pub mod target;

use std::path::PathBuf;

/// The folder with the inputs of a target, each in a file.
pub fn corpus(target: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target)
}
