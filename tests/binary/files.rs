//! Is every file written, or its failure reported? Devices, links, full disks, missing folders.
#![cfg(unix)]

use std::os::unix::fs::{FileTypeExt, symlink};
use std::path::Path;
use std::process::Stdio;

use crate::temp_folder::TempFolder;

/// A device on which every write fails, where the system has it.
fn full_disk() -> Option<&'static Path> {
    let device = Path::new("/dev/full");
    let there = device.metadata().is_ok_and(|metadata| metadata.file_type().is_char_device());
    there.then_some(device)
}

#[test]
fn a_full_disk_behind_a_link_is_noticed_and_stays_what_it_is() {
    let Some(device) = full_disk() else { return };
    let temp = TempFolder::new();
    for (link, arguments) in [
        ("link.html", "calibrate -o link.html"),
        ("link.toml", "config export link.toml --force"),
        ("plan.toml", "campaign plan -o plan.toml"),
    ] {
        symlink(device, temp.path(link)).unwrap();
        let outcome = temp.run(arguments);
        assert_eq!(outcome.code, Some(2), "{arguments}: {outcome:#?}");
        assert!(outcome.stderr.contains("cannot write"), "{arguments}: {outcome:#?}");
        assert!(outcome.stderr.contains(link), "{arguments}: {outcome:#?}");
        assert!(!outcome.stderr.contains("link.toml written"), "{arguments}: {outcome:#?}");
        assert!(temp.path(link).is_symlink(), "{arguments}");
        assert_eq!(full_disk(), Some(device), "{arguments} replaced the device");
    }
    assert_eq!(temp.listing(), ["link.html", "link.toml", "plan.toml"]);
}

#[test]
fn a_result_that_cannot_be_written_is_an_error() {
    let Some(device) = full_disk() else { return };
    let temp = TempFolder::new();
    for arguments in ["config export -", "identify --json", "wheel-weight --lateral 1mm"] {
        let full = std::fs::OpenOptions::new().write(true).open(device).unwrap();
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_beeline"));
        command.args(arguments.split_whitespace()).current_dir(temp.path("."));
        let output = command.stdout(Stdio::from(full)).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments}: {output:?}");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(stderr.contains("cannot write the result"), "{arguments}: {stderr}");
    }
}

#[test]
fn a_picture_goes_into_a_pipe_and_the_pipe_stays() {
    let temp = TempFolder::new();
    let pipe = temp.path("pipe.svg");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || std::fs::read_to_string(pipe).unwrap()
    });
    temp.run("calibrate -o pipe.svg").ok();
    assert!(reader.join().unwrap().contains("</svg>"));
    assert!(pipe.metadata().unwrap().file_type().is_fifo());
}

#[test]
fn a_flash_that_cannot_be_written_is_refused_before_the_drive() {
    let temp = TempFolder::new();
    symlink("/dev/null", temp.path("nothing")).unwrap();
    for (flash, expected) in [
        ("nowhere/flash", "there is no folder"),
        ("/proc/flash", "/proc/flash"),
        ("nothing", "remembers nothing"),
    ] {
        for command in ["calibrate", "drive straight 1rev", "config save"] {
            let message = temp.run(&format!("{command} --flash {flash}")).refused();
            assert!(message.contains(flash) && message.contains(expected), "{command}: {message}");
            assert!(!message.contains("Driving"), "{command}: {message}");
        }
    }
    let null = Path::new("/dev/null").metadata().unwrap().file_type();
    assert!(null.is_char_device(), "the device is no flash");
    assert_eq!(temp.listing(), ["nothing"]);
}

#[test]
fn a_flash_behind_a_link_is_written_where_it_leads() {
    let temp = TempFolder::new();
    std::fs::create_dir(temp.path("far")).unwrap();
    symlink("far/flash", temp.path("flash")).unwrap();
    temp.run("config set geometry.wheel_weight 0.99 --save --flash flash").ok();
    assert!(temp.path("flash").is_symlink());
    let value = temp.run("config get geometry.wheel_weight --json --flash far/flash").ok().json();
    assert_eq!(value.as_f64(), Some(0.99));
    assert_eq!(temp.listing(), ["far", "flash"]);
}
