//! A campaign becomes one long log as other programs write it, and is imported again: the same effect, the same value, the
//! clock found.

mod bad_input;
mod odd_bags;
mod odd_logs;
#[expect(dead_code, reason = "the tests of the executable use the rest")]
mod one_log;

use std::path::{Path, PathBuf};

use campaign::Campaign;
use import::source::{Choice, Sources};
use import::text::parse_mappings;
use import::understand::{Hints, Understood, understand};
use import::write::write;
use one_log::OneLog;
use robot_model::explain::explain;
use robot_model::recording::Recording;

const MYSTERY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/mystery-robot");

/// How late the poses are made \[s\].
const LATE_S: f64 = 3.7234;

fn imported(paths: &[PathBuf], choice: &Choice, hints: &Hints) -> Understood {
    let sources = Sources::open(paths, &choice.mappings).unwrap();
    let chosen = sources.choose(choice).unwrap();
    understand(chosen.wheels, &chosen.poses, hints, chosen.same_clock).unwrap()
}

/// The speed growth that `explain` finds in a folder, and its standard error.
fn speed_growth(folder: &Path) -> (f64, f64) {
    let (read, recordings) = Campaign::read_both(folder).unwrap();
    let model = recordings.into_model(&read, folder).unwrap();
    let answer = explain(&model).unwrap();
    let matters = answer.steps.iter().filter(|step| step.matters);
    let effects: Vec<&str> = matters.map(|step| step.effect.as_str()).collect();
    assert_eq!(effects, ["speed_growth"]);
    let found = &answer.steps[0].parameters[0];
    (found.value, found.sigma)
}

/// The names of the runs that there are in the mystery, but for the one in which the robot rests.
const NAMES: [&str; 20] = [
    "out_and_back",
    "out_and_back",
    "out_and_back",
    "out_and_back",
    "spin_left",
    "spin_right",
    "spin_left",
    "spin_right",
    "arc_left",
    "arc_right",
    "arc_left",
    "arc_right",
    "arc_left",
    "arc_right",
    "arc_left",
    "arc_right",
    "square_left",
    "square_right",
    "out_and_back",
    "out_and_back",
];

fn hints() -> Hints {
    Hints { wheel_radius_m: Some(0.036), track_width_m: Some(0.372), ..Hints::default() }
}

fn check_clock_and_runs(understood: &Understood) {
    let off_s = understood.clock.late_s - LATE_S;
    assert!(off_s.abs() < 0.002, "the clock is off by {off_s:.4} s");
    let names: Vec<&str> = understood.runs.iter().map(|run| run.name.as_str()).collect();
    assert_eq!(names, NAMES);
    assert_eq!(understood.left_out, []);
    let told: Vec<&str> = understood.notes.iter().map(|note| note.text.as_str()).collect();
    assert!(told.iter().any(|told| told.contains("headings are turned")), "{told:?}");
}

#[test]
fn a_bag_with_the_tracker_in_its_own_frame_and_clock_gives_the_same_verdict() {
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("drive.mcap");
    std::fs::write(&bag, OneLog::of(Path::new(MYSTERY), LATE_S).bag()).unwrap();
    let understood = imported(&[bag], &Choice::default(), &hints());
    check_clock_and_runs(&understood);
    let campaign = folder.path().join("my-robot");
    let written = write(&understood, &campaign, false).unwrap();
    assert_eq!((written.names.len(), written.were_there), (NAMES.len(), 0));
    let again = write(&understood, &campaign, false).unwrap();
    assert_eq!((again.names, again.were_there), (written.names, NAMES.len()));
    let mut fewer = understood.clone();
    fewer.runs.pop();
    let refused = write(&fewer, &campaign, false).unwrap_err().to_string();
    assert!(refused.contains("has runs already; choose another folder with -o"), "{refused}");
    let (value, _) = speed_growth(&campaign);
    let (expected, sigma) = speed_growth(Path::new(MYSTERY));
    assert!((value - expected).abs() < sigma, "{value}, and without a detour {expected} ± {sigma}");
}

/// The bag holds the same log, and what becomes of that is tested above: here, that it is the same.
#[test]
fn a_table_and_a_trajectory_give_the_same_runs_and_nobody_need_know_the_clocks() {
    let folder = tempfile::tempdir().unwrap();
    let (table, track) = (folder.path().join("wheels.csv"), folder.path().join("track.tum"));
    let log = OneLog::of(Path::new(MYSTERY), LATE_S);
    std::fs::write(&table, log.table()).unwrap();
    std::fs::write(&track, log.trajectory()).unwrap();
    let mappings = parse_mappings("left_counts=enc_l,right_counts=enc_r,t_s=stamp:ns").unwrap();
    let choice = Choice { mappings, ..Choice::default() };
    let understood =
        imported(&[table, track], &choice, &Hints { counts_per_rev: Some(900.0), ..hints() });
    check_clock_and_runs(&understood);
    let bag = folder.path().join("drive.mcap");
    std::fs::write(&bag, log.bag()).unwrap();
    let by_bag = imported(&[bag], &Choice::default(), &hints());
    for (a, b) in understood.runs.iter().zip(&by_bag.runs) {
        let began_s = a.started_s - b.started_s;
        assert_eq!(a.recording.measured_poses.len(), b.recording.measured_poses.len());
        for (a, b) in a.recording.measured_poses.iter().zip(&b.recording.measured_poses) {
            assert!((began_s + a.t_s - b.t_s).abs() < 1e-4, "{a:?} {b:?}");
            assert!((a.heading_rad.unwrap() - b.heading_rad.unwrap()).abs() < 1e-6, "{a:?} {b:?}");
        }
        let last = |run: &Recording| run.wheels[run.wheels.len() - 1].phi_rad;
        assert!((last(&a.recording).left - last(&b.recording).left).abs() < 1e-9);
    }
}

#[test]
fn a_run_in_which_the_tracker_saw_nothing_is_left_out_and_the_others_stay() {
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("drive.mcap");
    let mut log = OneLog::of_runs(Path::new(MYSTERY), LATE_S, 4..9);
    // A spin of 9 s, from 88 s on.
    let blind_s = log.wheels[0].0 + 87.0;
    log.poses.retain(|pose| !(blind_s..blind_s + 12.0).contains(&(pose.t_s - LATE_S)));
    std::fs::write(&bag, log.bag()).unwrap();
    let understood = imported(&[bag], &Choice::default(), &hints());
    let told: Vec<&str> = understood.left_out.iter().map(|left| left.why.as_str()).collect();
    assert_eq!(told, ["no pose was measured in it"]);
    assert_eq!(understood.runs.len(), 4);
}
