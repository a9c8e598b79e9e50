//! A disk that takes nothing, or no more: a limit of the system's on the size of files, as no test can fill a disk.

use std::process::{Command, Stdio};

use crate::example::runs_of;
use crate::outcome::{Outcome, collect};
use crate::temp_folder::{TempFolder, words};

/// The command where no file grows beyond so many blocks of half a kilobyte: what is beyond is an error.
fn limited(temp: &TempFolder, blocks: u32, line: &str) -> Outcome {
    let limited = temp.command(&words(line));
    let script = format!("ulimit -f {blocks}; exec \"$0\" \"$@\"");
    let mut shell = Command::new("sh");
    shell.args(["-c", &script]).arg(limited.get_program()).args(limited.get_args());
    for (name, value) in limited.get_envs() {
        match value {
            Some(value) => shell.env(name, value),
            None => shell.env_remove(name),
        };
    }
    shell.current_dir(limited.get_current_dir().unwrap());
    shell.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    collect(shell.spawn().unwrap())
}

/// All files and folders.
fn everything(temp: &TempFolder) -> Vec<String> {
    fn below(folder: &std::path::Path, found: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            found.push(path.to_string_lossy().into_owned());
            if path.is_dir() {
                below(&path, found);
            }
        }
    }
    let mut found = Vec::new();
    below(&temp.path(""), &mut found);
    found.sort();
    found
}

#[test]
fn a_command_that_finds_no_room_says_so_and_leaves_nothing_new() {
    let temp = TempFolder::new();
    runs_of(&temp, "mystery-robot", &[""], "robot");
    let before = everything(&temp);
    for command in [
        "record new straight 0.3m",
        "campaign record a/b/new --run straight",
        "campaign plan -o plan.toml",
        "report robot -o page.html",
        "export robot --to ros2 -o file.yaml",
        "export robot --to tum -o tracks",
        "export robot --to mcap -o robot.mcap",
        "config export config.toml",
        "key new robot.key",
        "model add speed_growth robot",
        "fleet robot --table values.csv",
    ] {
        let message = limited(&temp, 0, command).refused();
        assert!(message.contains("no file may be that large here"), "{command}: {message}");
        assert!(message.contains("try: raise the limit"), "{command}: {message}");
        assert_eq!(everything(&temp), before, "{command}");
    }
    let outcome = limited(&temp, 0, "sim --listen tcp:127.0.0.1:0 --camera track.csv");
    assert_eq!(outcome.code, Some(2), "{outcome:#?}");
    assert_eq!(everything(&temp), before);
}

/// What was done before the disk was full is said, and no more.
#[test]
fn a_command_that_has_done_a_part_says_which() {
    let temp = TempFolder::new();
    temp.run("config save --flash flash").ok();
    let before = temp.read("flash");
    // Room for the robot's flash, not for the experiments.
    let outcome = limited(&temp, 16, "tune --record experiments --flash flash");
    assert_eq!(outcome.code, Some(2), "{outcome:#?}");
    assert!(outcome.stdout.contains("tuned:"), "{outcome:#?}");
    assert!(outcome.stderr.contains("this file is as it was before"), "{outcome:#?}");
    assert_ne!(temp.read("flash"), before);
    // Room for the run, not for its bag.
    let line = "record robot straight 0.3m --mcap drive.mcap";
    temp.run(&line.replace("drive", "other")).ok();
    let blocks = std::fs::metadata(temp.path("other.mcap")).unwrap().len() / 512 - 1;
    let outcome = limited(&temp, u32::try_from(blocks).unwrap(), line);
    assert_eq!(outcome.code, Some(2), "{outcome:#?}");
    let said = outcome.stderr;
    assert!(said.contains("02_straight.csv: recorded"), "{said}");
    assert!(said.contains("makes a bag of a campaign at any time"), "{said}");
}

#[test]
fn a_run_that_finds_no_room_leaves_the_campaign_as_it_was() {
    let temp = TempFolder::new();
    // Room for `robot.toml`, not for a run.
    let message = limited(&temp, 4, "record robot straight 0.3m").refused();
    assert!(message.contains("try: raise the limit"), "{message}");
    assert!(!temp.path("robot/runs").exists());
    temp.run("record robot straight 0.3m").ok();
    let before = everything(&temp);
    limited(&temp, 4, "record robot straight 0.3m").refused();
    assert_eq!(everything(&temp), before);
    temp.run("compare robot").ok();
}
