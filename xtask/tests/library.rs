//! What the firmware's library brings with it.

use std::process::Command;

/// The packages that the library is built of for this chip, or for the desktop.
fn packages(target: &[&str]) -> String {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "-p", "firmware", "--edges", "normal,build", "--prefix", "none", "--locked"])
        .args(target)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn on_a_desktop_and_without_a_board_the_library_brings_nothing_of_the_stm32s() {
    let chip = ["--target", "thumbv7em-none-eabihf"];
    let no_board = [&chip[..], &["--no-default-features"]].concat();
    for target in [&[][..], &no_board] {
        let packages = packages(target);
        assert!(packages.contains("sequential-storage"), "{packages}");
        assert!(!packages.contains("embassy-stm32"), "{packages}");
    }
    assert!(packages(&chip).contains("embassy-stm32"), "with a board it does");
}
