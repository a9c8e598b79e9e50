//! Gives the linker a board's memory map. Does nothing for a desktop.

use std::path::PathBuf;

fn main() {
    println!("cargo::rerun-if-changed=memory");
    println!("cargo::rerun-if-changed=build.rs");
    let variable = |name: &str| std::env::var_os(name);
    if variable("CARGO_CFG_TARGET_OS").is_none_or(|os| os != "none") {
        return;
    }
    let boards = ["nucleo_f429zi", "nucleo_f446re"];
    let chosen =
        |board: &&str| variable(&format!("CARGO_FEATURE_BOARD_{}", board.to_uppercase())).is_some();
    if let Some(board) = boards.into_iter().find(chosen) {
        let out = PathBuf::from(variable("OUT_DIR").expect("cargo sets OUT_DIR"));
        std::fs::copy(format!("memory/{board}.x"), out.join("memory.x"))
            .expect("the memory map is there");
        println!("cargo::rustc-link-search={}", out.display());
        for argument in ["--nmagic", "--icf=all", "-Tlink.x", "-Tdefmt.x"] {
            println!("cargo::rustc-link-arg-bins={argument}");
        }
    }
}
