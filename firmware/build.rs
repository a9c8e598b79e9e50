//! Gives the linker a board's memory map. Does nothing for a desktop.

use std::path::PathBuf;

fn main() {
    println!("cargo::rerun-if-changed=memory");
    println!("cargo::rerun-if-changed=build.rs");
    let variable = |name: &str| std::env::var_os(name);
    if variable("CARGO_CFG_TARGET_OS").is_none_or(|os| os != "none") {
        return;
    }
    // Boards and their memory maps.
    let boards = [
        ("NUCLEO_F429ZI", "two_banks"),
        ("NUCLEO_F446RE", "one_bank"),
        ("NUCLEO_F411RE", "one_bank"),
        ("BLACK_PILL_F411", "one_bank"),
        ("NUCLEO_G474RE", "two_small_banks"),
    ];
    let chosen =
        |(board, _): &(&str, &str)| variable(&format!("CARGO_FEATURE_BOARD_{board}")).is_some();
    if let Some((_, map)) = boards.into_iter().find(chosen) {
        let out = PathBuf::from(variable("OUT_DIR").expect("cargo sets OUT_DIR"));
        std::fs::copy(format!("memory/{map}.x"), out.join("memory.x"))
            .expect("the memory map is there");
        println!("cargo::rustc-link-search={}", out.display());
        for argument in ["--nmagic", "--icf=all", "-Tlink.x", "-Tdefmt.x"] {
            println!("cargo::rustc-link-arg-bins={argument}");
        }
    }
}
