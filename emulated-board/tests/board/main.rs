//! What the flashed image does, and how it bears what goes wrong.

mod attack;
mod chip;
mod dead_host;
mod drivers;
mod faults;
mod hang;
mod key;
mod network;
/// A NOR flash in memory, as the store's own tests have it; here its power never goes.
#[allow(dead_code)]
#[path = "../../../firmware/tests/store/nor.rs"]
mod nor;
mod paper;
mod power_cut;
mod random_faults;
mod robot;
mod stack;
mod stopped_task;
mod storage;
mod telemetry;
mod translations;

use std::path::Path;

use emulated_board::{Emulation, RunResult};
use sim_target::Scenario;

/// The image that `cargo xtask test` has built, the very bytes that are flashed.
fn image() -> std::path::PathBuf {
    let image = std::env::var_os("BEELINE_IMAGE");
    image.expect("BEELINE_IMAGE names the image: run these tests by `cargo xtask test`").into()
}

/// The paper's robot.
fn scenario() -> (std::path::PathBuf, Scenario) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../sim-target/scenarios/paper.toml");
    let scenario = Scenario::load(&path).unwrap();
    (path, scenario)
}

fn emulation() -> Emulation {
    Emulation::of(image(), scenario().1)
}

/// What an emulated life must leave behind in any case: no restart, and no access that the emulator
/// could not answer as the chip would.
fn uneventful<T>(ended: &RunResult<T>) {
    assert_eq!(ended.resets, 0);
    assert!(ended.unexpected.is_empty(), "{:#?}", ended.unexpected);
}
