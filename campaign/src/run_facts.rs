//! The facts of runs in `robot.toml`, written so that a run and its facts appear together.
//!
//! ```text
//! robot.toml: [[run]] with `pending = true`  ->  runs/NN_name.csv appears  ->  `pending` is removed
//! ```
//!
//! The run's file appears in one step, and its facts are there before it. A pending entry without its file is no run: readers
//! ignore it, and the next writer removes it. So a process may end anywhere, and no run is without its facts.

use std::path::Path;

use crate::bounded_read;
use crate::disk::Disk;
use crate::error::{CampaignError, Place};
use crate::file::write_own_on;
use crate::robot_toml::{RobotFile, RunFacts, start_of_run};

/// Adds the facts of runs whose files do not exist yet. The text before them stays as people wrote it.
pub(crate) fn announce(
    disk: &dyn Disk,
    toml: &Path,
    facts: &[RunFacts],
) -> Result<(), CampaignError> {
    let pending: Vec<RunFacts> =
        facts.iter().map(|facts| RunFacts { pending: true, ..facts.clone() }).collect();
    add(disk, toml, &pending)
}

/// Adds the facts of runs whose files exist.
pub(crate) fn add(disk: &dyn Disk, toml: &Path, facts: &[RunFacts]) -> Result<(), CampaignError> {
    write(disk, toml, &with_facts(toml, facts)?)
}

/// Removes `pending` from entries whose run is there, and entries whose run never came.
pub(crate) fn resolve_pending(disk: &dyn Disk, folder: &Path) -> Result<(), CampaignError> {
    let toml = folder.join("robot.toml");
    let mut robot = RobotFile::read(&toml)?;
    if robot.runs.iter().all(|facts| !facts.pending) {
        return Ok(());
    }
    let mut text = read(&toml)?;
    // From the last one, as the places of those before it stay.
    for index in
        (0..robot.runs.len()).rev().filter(|index| robot.runs[*index].pending).collect::<Vec<_>>()
    {
        let there = folder.join("runs").join(format!("{}.csv", robot.runs[index].name)).exists();
        let section = section(&text, index);
        if there {
            robot.runs[index].pending = false;
            let lines = text[section.clone()].split_inclusive('\n');
            let kept: String = lines.filter(|line| !is_pending(line)).collect();
            text.replace_range(section, &kept);
        } else {
            robot.runs.remove(index);
            text.replace_range(section, "");
            text.truncate(text.trim_end().len());
            text.push('\n');
        }
    }
    // Somebody may have written the entries in another form: what cannot be edited as text stays.
    if RobotFile::parse(&toml, &text).is_ok_and(|edited| edited == robot) {
        write(disk, &toml, &text)?;
    }
    Ok(())
}

fn is_pending(line: &str) -> bool {
    line.trim_start().strip_prefix("pending").is_some_and(|rest| rest.trim_start().starts_with('='))
}

/// The bytes of a `[[run]]`, to the next section or the end.
fn section(text: &str, index: usize) -> std::ops::Range<usize> {
    let start = start_of_run(text, index);
    let mut end = start;
    for (number, line) in text[start..].split_inclusive('\n').enumerate() {
        if number > 0 && line.trim_start().starts_with('[') {
            break;
        }
        end += line.len();
    }
    start..end
}

/// The text of a `robot.toml` with these facts at its end; refused if it could not be read again.
pub(crate) fn with_facts(toml: &Path, facts: &[RunFacts]) -> Result<String, CampaignError> {
    let mut text = read(toml)?;
    if !text.ends_with('\n') {
        text.push('\n');
    }
    for facts in facts {
        let entry = toml::to_string(facts).map_err(|error| {
            CampaignError::new(Place::whole(toml), error.to_string(), "check the facts of the run")
        })?;
        text.push_str("\n[[run]]\n");
        text.push_str(&entry);
    }
    RobotFile::parse(toml, &text).map_err(|error| {
        let problem = format!("the facts of a run cannot be added at its end: {}", error.problem);
        CampaignError::new(error.place, problem, "write what it says of runs as [[run]] sections")
    })?;
    Ok(text)
}

fn read(toml: &Path) -> Result<String, CampaignError> {
    bounded_read::read_keys(toml).map_err(|error| CampaignError::io(toml, "read it", error))
}

fn write(disk: &dyn Disk, toml: &Path, text: &str) -> Result<(), CampaignError> {
    write_own_on(disk, toml, text.as_bytes())
        .map_err(|error| CampaignError::io(toml, "write it", error.into()))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;
    use crate::{Campaign, CampaignWriter, Column, Row};
    use shared_proto::WheelPair;

    const TOML: &str = "# mine\nname = \"r\"\nwheel_radius_m = 0.036\ntrack_width_m = 0.372\ncounts_per_rev = 900\n";
    const CSV: &str = "t_s,left_counts,right_counts\n0,0,0\n1,5,5\n";
    const PENDING: &str =
        "\n[[run]]\nname = \"01_a\"\npayload_kg = 2.5\nheld_out = true\npending = true\n";

    fn folder(toml: &str, runs: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("runs")).unwrap();
        fs::write(folder.path().join("robot.toml"), toml).unwrap();
        for (number, run) in runs.iter().enumerate() {
            // No copies of one another.
            let csv = CSV.replace("1,5,5", &format!("1,5,{}", 5 + number));
            fs::write(folder.path().join(format!("runs/{run}.csv")), csv).unwrap();
        }
        folder
    }

    fn writer(folder: &Path) -> CampaignWriter {
        let robot = RobotFile::read(&folder.join("robot.toml")).unwrap();
        CampaignWriter::open(folder, &robot).unwrap()
    }

    fn text(folder: &Path) -> String {
        fs::read_to_string(folder.join("robot.toml")).unwrap()
    }

    /// What another process finds at each instant is what a process that is killed at that instant leaves.
    #[test]
    fn at_no_instant_is_a_run_without_its_facts() {
        let folder = folder(TOML, &[]);
        let path = folder.path();
        let over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let watched = scope.spawn(|| {
                let mut seen = 0;
                while !over.load(Ordering::Relaxed) {
                    let Some(campaign) = Campaign::read_if_any(path).unwrap() else { continue };
                    for run in &campaign.runs {
                        let facts = (run.facts.payload_kg, run.facts.held_out, run.facts.pending);
                        assert_eq!(facts, (Some(2.5), true, false), "{}", run.name);
                    }
                    seen = seen.max(campaign.runs.len());
                }
                seen
            });
            let writer = writer(path);
            for _ in 0..40 {
                let mut run = writer.start_run("a", &[Column::X, Column::Y]).unwrap();
                for t in 0..3 {
                    let counts = WheelPair::both(Some(f64::from(t)));
                    run.push(&Row { t_s: f64::from(t), counts, ..Row::default() }).unwrap();
                }
                let facts =
                    RunFacts { payload_kg: Some(2.5), held_out: true, ..RunFacts::default() };
                run.finish(facts).unwrap();
            }
            over.store(true, Ordering::Relaxed);
            assert!(watched.join().unwrap() > 0, "the reader saw no run");
        });
        assert!(!text(path).contains("pending"));
    }

    #[test]
    fn facts_without_their_run_are_no_run_and_the_next_writer_removes_them() {
        let folder = folder(&format!("{TOML}{PENDING}"), &["00_b"]);
        let campaign = Campaign::read(folder.path()).unwrap();
        assert_eq!((campaign.runs.len(), campaign.robot.runs.len()), (1, 0));
        drop(writer(folder.path()));
        assert_eq!(text(folder.path()), TOML);
    }

    #[test]
    fn facts_of_a_run_that_appeared_hold_and_the_next_writer_removes_the_mark() {
        let later = "\n[[run]]\nname = \"00_b\"\nstarted_s = 3 # noon\n";
        let folder = folder(&format!("{TOML}{PENDING}{later}"), &["00_b", "01_a"]);
        let held_out = || Campaign::read(folder.path()).unwrap().runs[1].facts.clone();
        assert_eq!((held_out().payload_kg, held_out().held_out), (Some(2.5), true));
        drop(writer(folder.path()));
        let settled = PENDING.replace("pending = true\n", "");
        assert_eq!(text(folder.path()), format!("{TOML}{settled}{later}"));
        assert_eq!((held_out().payload_kg, held_out().held_out), (Some(2.5), true));
    }

    #[test]
    fn facts_that_an_older_version_lost_are_restored_and_those_that_a_person_wrote_stay() {
        let person = "\n[[run]]\nname = \"00_b\"\nstarted_s = 3\n";
        let folder = folder(&format!("{TOML}{person}"), &["00_b", "01_a"]);
        let writer = writer(folder.path());
        let facts = RunFacts { held_out: true, ..RunFacts::default() };
        assert!(!writer.restore_facts("00_b", &facts).unwrap());
        assert!(writer.restore_facts("01_a", &facts).unwrap());
        let runs = Campaign::read(folder.path()).unwrap().runs;
        assert_eq!((runs[0].facts.held_out, runs[1].facts.held_out), (false, true));
    }
}
