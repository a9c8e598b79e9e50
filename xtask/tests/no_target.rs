//! `cargo xtask firmware` where nothing can be fetched: one error, with what to do.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

/// Programs that fail, as without a network: a compiler without the target, a rustup that cannot fetch it, and
/// an apt-get that finds no package.
const PROGRAMS: [(&str, &str); 5] = [
    ("rustc", "echo /nowhere"),
    ("rustup", "echo 'error: could not download file' >&2; exit 1"),
    ("dpkg", "exit 1"),
    ("apt-get", "test \"$1\" = --version || { echo 'E: Unable to locate package' >&2; exit 100; }"),
    ("sudo", "exit 1"),
];

fn folder_of_programs(folder: &Path) {
    for (name, script) in PROGRAMS {
        let path = folder.join(name);
        std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).expect("writable");
        std::fs::set_permissions(&path, PermissionsExt::from_mode(0o755)).expect("it is ours");
    }
    let test = folder.join("test");
    if !test.exists() {
        std::os::unix::fs::symlink("/usr/bin/test", test).expect("writable");
    }
}

#[test]
fn without_a_target_and_without_a_network_one_error_says_what_to_do() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("offline");
    std::fs::create_dir_all(&folder).expect("writable");
    folder_of_programs(&folder);
    let output = Command::new(env!("CARGO_BIN_EXE_xtask"))
        .args(["firmware", "--board", "nucleo-f429zi"])
        .env("PATH", &folder)
        .output()
        .expect("xtask runs");
    assert!(!output.status.success());
    let errors = String::from_utf8_lossy(&output.stderr);
    let ours: Vec<&str> = errors.lines().filter(|line| line.starts_with("xtask: ")).collect();
    assert_eq!(ours.len(), 1, "{errors}");
    assert!(ours[0].contains("thumbv7em-none-eabihf is missing and cannot be fetched"), "{errors}");
    for advice in [
        "run `rustup target add thumbv7em-none-eabihf` in this folder",
        "run `apt-get install rustc-web cargo-web rust-web-src`",
    ] {
        assert!(errors.contains(advice), "{errors}");
    }
}
