//! A campaign folder that two processes use, that a killed process left, or that somebody else made.

use std::path::{Path, PathBuf};

use campaign::Campaign;
use campaign::lock::FolderLock;

use crate::outcome::{Outcome, wait_for};
use crate::temp_folder::TempFolder;

const TWO_RUNS: &str = "\
acceleration_mps2 = 0.3
[[run]]
name = \"a\"
payload_kg = 2.5
held_out = true
pieces = [{ rest_s = 1 }]
[[run]]
name = \"b\"
pieces = [{ straight_m = 0.3, speed_mps = 0.2 }]
";

fn record(temp: &TempFolder) -> Outcome {
    temp.write("two.toml", TWO_RUNS);
    temp.run("campaign record robot --plan two.toml")
}

#[test]
fn a_second_writer_is_refused_with_the_name_of_the_first_and_readers_are_not() {
    let temp = TempFolder::new();
    record(&temp).ok();
    let lock = FolderLock::take(&temp.path("robot")).unwrap();
    let before = temp.read("robot/robot.toml");
    for command in ["record robot straight 0.3m", "campaign record robot --run straight"] {
        let message = temp.run(command).refused();
        let process = format!("process {}", std::process::id());
        assert!(message.contains(&process) && message.contains("is writing into"), "{message}");
    }
    assert_eq!(temp.read("robot/robot.toml"), before);
    temp.run("compare robot").ok();
    drop(lock);
    temp.run("record robot straight 0.3m").ok();
    assert_eq!(Campaign::read(&temp.path("robot")).unwrap().runs.len(), 3);
}

#[test]
fn a_writer_that_was_killed_locks_nobody_out_and_the_next_continues() {
    let temp = TempFolder::new();
    temp.write("two.toml", TWO_RUNS);
    // It waits at its first question.
    let arguments = ["campaign", "record", "robot", "--plan", "two.toml", "--measure", "ask"];
    let mut child = temp.spawn(&arguments);
    wait_for("the lock", || temp.path("robot/plan.toml").exists().then_some(()));
    let message = record(&temp).refused();
    assert!(message.contains(&format!("process {}", child.id())), "{message}");
    assert!(message.contains("campaign record"), "{message}");
    child.kill().unwrap();
    child.wait().unwrap();
    record(&temp).ok();
    let runs = Campaign::read(&temp.path("robot")).unwrap().runs;
    assert_eq!(runs.iter().map(|run| run.facts.held_out).collect::<Vec<_>>(), [true, false]);
}

#[test]
fn a_campaign_that_lost_the_facts_of_a_run_gets_them_again_from_its_plan() {
    let temp = TempFolder::new();
    record(&temp).ok();
    let whole = String::from_utf8(temp.read("robot/robot.toml")).unwrap();
    let begin = whole.find("[[run]]\nname = \"01_a\"").expect("its entry");
    let end = begin + 7 + whole[begin + 7..].find("[[run]]").expect("the next one");
    let entry = &whole[begin..end];
    assert!(entry.contains("payload_kg = 2.5\nheld_out = true\n"), "{whole}");
    temp.write("robot/robot.toml", &whole.replace(entry, ""));
    let outcome = record(&temp).ok();
    assert!(outcome.stderr.contains("01_a") && outcome.stderr.contains("restored"), "{outcome:#?}");
    let facts = Campaign::read(&temp.path("robot")).unwrap().runs[0].facts.clone();
    assert_eq!((facts.payload_kg, facts.held_out), (Some(2.5), true));
}

/// Every file of the folder with its bytes.
fn bytes(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    for folder in [folder.to_owned(), folder.join("runs")] {
        let files = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
        all.extend(files.filter(|file| file.is_file()).map(|file| {
            let bytes = std::fs::read(&file).unwrap();
            (file.file_name().unwrap().into(), bytes)
        }));
    }
    all.sort();
    all
}

#[test]
fn a_simulated_campaign_that_was_interrupted_has_the_bytes_of_one_that_was_not() {
    let temp = TempFolder::new();
    // Its distances have more digits than a plan's file.
    temp.run("campaign record whole --floor 1.7mx1.9m --payload 1kg").ok();
    let whole = bytes(&temp.path("whole"));
    let toml = String::from_utf8(temp.read("whole/robot.toml")).unwrap();
    for kept in [1, 12] {
        let folder = temp.path(&format!("kept{kept}"));
        std::fs::create_dir_all(folder.join("runs")).unwrap();
        // As an interruption leaves it: with the first runs and their facts.
        let upto = toml.match_indices("\n[[run]]").nth(kept).unwrap().0;
        std::fs::write(folder.join("robot.toml"), &toml[..upto]).unwrap();
        std::fs::copy(temp.path("whole/plan.toml"), folder.join("plan.toml")).unwrap();
        let runs =
            whole.iter().filter(|(name, _)| name.extension().is_some_and(|end| end == "csv"));
        for (name, bytes) in runs.take(kept) {
            std::fs::write(folder.join("runs").join(name), bytes).unwrap();
        }
        temp.run(&format!("campaign record kept{kept}")).ok();
        let continued = bytes(&folder);
        assert_eq!(continued.len(), whole.len());
        for (there, here) in continued.iter().zip(&whole) {
            assert!(there == here, "{}: other bytes after {kept} runs", there.0.display());
        }
    }
}

#[test]
fn recording_a_run_again_draws_new_noise_and_the_whole_is_repeatable() {
    let record = || {
        let temp = TempFolder::new();
        for _ in 0..3 {
            temp.run("record robot straight 0.5m --seed 5").ok();
        }
        bytes(&temp.path("robot"))
    };
    let first = record();
    assert_eq!(first, record());
    let runs: Vec<_> = first.iter().filter(|(_, bytes)| bytes.starts_with(b"t_s,")).collect();
    assert_eq!(runs.len(), 3);
    assert!(runs[0].1 != runs[1].1 && runs[1].1 != runs[2].1 && runs[0].1 != runs[2].1);
}

#[test]
fn copies_of_runs_count_once_in_what_is_compared_and_are_said_in_one_line() {
    let temp = TempFolder::new();
    for _ in 0..3 {
        temp.run("record robot straight 1m").ok();
    }
    let once = temp.run("compare robot --json").ok();
    assert!(!once.stderr.contains("cop"), "{once:#?}");
    let text = String::from_utf8(temp.read("robot/runs/01_straight.csv")).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let later = |line: &str| {
        let (t_s, rest) = line.split_once(',').unwrap();
        format!("{:.6},{rest}", t_s.parse::<f64>().unwrap() + 77.25)
    };
    let shifted: Vec<String> = lines[1..].iter().map(|line| later(line)).collect();
    temp.write("robot/runs/04_same.csv", &text);
    temp.write("robot/runs/05_later.csv", &format!("{}\n{}\n", lines[0], shifted.join("\n")));
    temp.write("robot/runs/06_short.csv", &lines[..lines.len() / 2].join("\n"));
    let again = temp.run("compare robot --json").ok();
    assert_eq!(again.stdout, once.stdout);
    let said: Vec<&str> = again.stderr.lines().filter(|line| line.contains("copies")).collect();
    assert_eq!(said.len(), 1, "{again:#?}");
    for words in ["3 runs are copies", "04_same of 01_straight", "05_later of", "06_short of"] {
        assert!(said[0].contains(words), "{words}: {}", said[0]);
    }
}

#[test]
#[cfg(unix)]
fn files_of_others_are_not_waited_for_written_through_or_passed_over() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    use std::os::unix::fs::symlink;
    let temp = TempFolder::new();
    record(&temp).ok();
    let in_runs = |name: &[u8]| temp.path("robot/runs").join(OsStr::from_bytes(name));
    // Passed over, and said.
    std::fs::copy(temp.path("robot/runs/02_b.csv"), in_runs(b"03_c.CSV")).unwrap();
    std::fs::copy(temp.path("robot/runs/02_b.csv"), in_runs(b"04_\xff.csv")).unwrap();
    let said = temp.run("compare robot").ok().stderr;
    assert!(said.contains("03_c.CSV: this file was not read"), "{said}");
    assert!(said.contains("04_\u{fffd}.csv: this file was not read"), "{said}");
    // Never waited for, and never endless.
    let run = in_runs(b"05_d.csv");
    let pipe = |path: &Path| {
        assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
    };
    pipe(&run);
    let message = temp.run("compare robot").refused();
    assert!(message.contains("05_d.csv: cannot read it (it is a pipe or a device"), "{message}");
    std::fs::remove_file(&run).unwrap();
    symlink("/dev/zero", &run).unwrap();
    assert!(temp.run("compare robot").refused().contains("a pipe or a device, not a file"));
    std::fs::remove_file(&run).unwrap();
    for name in ["robot.toml", "model.toml"] {
        let path = temp.path("robot").join(name);
        let kept = std::fs::read(&path).ok();
        let _ = std::fs::remove_file(&path);
        pipe(&path);
        assert!(temp.run("compare robot").refused().contains("a pipe or a device, not a file"));
        std::fs::remove_file(&path).unwrap();
        if let Some(kept) = kept {
            std::fs::write(path, kept).unwrap();
        }
    }
    // Never written through.
    temp.write("precious", "mine");
    std::fs::create_dir_all(temp.path("new")).unwrap();
    symlink("../precious", temp.path("new/plan.toml")).unwrap();
    symlink("../nowhere", temp.path("new/.beeline-lock")).unwrap();
    assert!(temp.run("campaign record new --plan two.toml").refused().contains("cannot lock"));
    std::fs::remove_file(temp.path("new/.beeline-lock")).unwrap();
    let message = temp.run("campaign record new --plan two.toml").refused();
    assert!(message.contains("plan.toml: it is a link"), "{message}");
    assert_eq!(temp.read("precious"), b"mine");
    assert!(!temp.path("nowhere").exists());
}

#[test]
#[cfg(unix)]
fn nothing_of_a_campaign_is_written_through_a_link() {
    use std::os::unix::fs::symlink;
    let temp = TempFolder::new();
    let commands = ["record robot straight 0.3m", "campaign record robot --run straight"];
    record(&temp).ok();
    for name in ["robot.toml", "runs"] {
        let (there, elsewhere) = (temp.path("robot").join(name), temp.path(name));
        std::fs::rename(&there, &elsewhere).unwrap();
        symlink(&elsewhere, &there).unwrap();
        let before = (bytes(&temp.path("robot")), bytes(&temp.path("robot/runs/..")));
        for command in commands {
            let message = temp.run(command).refused();
            assert!(message.contains(name) && message.contains("it is a link"), "{message}");
        }
        assert_eq!((bytes(&temp.path("robot")), bytes(&temp.path("robot/runs/.."))), before);
        temp.run("compare robot").ok();
        std::fs::remove_file(&there).unwrap();
        std::fs::rename(&elsewhere, &there).unwrap();
    }
    temp.run(commands[0]).ok();
}

#[test]
fn a_lost_robot_toml_is_not_replaced_by_one_that_knows_nothing_of_the_runs() {
    let temp = TempFolder::new();
    record(&temp).ok();
    let toml = temp.read("robot/robot.toml");
    std::fs::remove_file(temp.path("robot/robot.toml")).unwrap();
    let before = bytes(&temp.path("robot"));
    for command in ["record robot straight 0.3m", "campaign record robot --plan two.toml"] {
        let message = temp.run(command).refused();
        assert!(message.contains("robot.toml: it is missing"), "{message}");
        assert!(message.contains("of the 2 runs in this folder"), "{message}");
    }
    assert_eq!(bytes(&temp.path("robot")), before);
    std::fs::write(temp.path("robot/robot.toml"), toml).unwrap();
    record(&temp).ok();
}

/// A pipe that nobody writes to: whoever reads it waits.
#[test]
#[cfg(unix)]
fn a_scenario_and_a_configuration_are_files_and_nothing_else_is_waited_for() {
    let temp = TempFolder::new();
    let pipe = temp.path("pipe.toml");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    std::os::unix::fs::symlink("/dev/zero", temp.path("endless.toml")).unwrap();
    for name in ["pipe.toml", "endless.toml"] {
        for line in [format!("identify --port sim:{name}"), format!("config import {name}")] {
            let message = temp.run(&line).refused();
            let says = "it is a pipe or a device, not a file";
            assert!(message.contains(name) && message.contains(says), "{line}: {message}");
        }
    }
}

#[test]
fn a_position_that_no_tracker_gives_is_refused_with_its_cell_and_range() {
    let temp = TempFolder::new();
    record(&temp).ok();
    let text = String::from_utf8(temp.read("robot/runs/02_b.csv")).unwrap();
    let (line, row) =
        text.lines().enumerate().find(|(line, row)| *line > 0 && !row.ends_with(',')).unwrap();
    let mut cells: Vec<&str> = row.split(',').collect();
    cells[6] = "1.79e308";
    temp.write("robot/runs/02_b.csv", &text.replace(row, &cells.join(",")));
    for command in ["compare robot", "explain robot"] {
        let message = temp.run(command).refused();
        let place =
            format!("02_b.csv, line {}, column 7: x_m = 1.79e308 is out of range", line + 1);
        assert!(message.contains(&place) && message.contains("from -1e8 to 1e8 m"), "{message}");
    }
}
