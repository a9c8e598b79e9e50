//! A campaign becomes one long log as other programs write it, and is imported again: the same effect, the same value, the
//! clock found.

mod bad_input;
mod one_log;

use std::path::{Path, PathBuf};

use campaign::Campaign;
use import::source::{Choice, Sources};
use import::text::parse_mappings;
use import::understand::{Hints, Understood, understand};
use import::write::write;
use one_log::OneLog;
use robot_model::explain::explain;

const MYSTERY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/mystery-robot");

/// How late the poses are made \[s\].
const LATE_S: f64 = 3.7234;

fn imported(paths: &[PathBuf], choice: &Choice, hints: &Hints) -> Understood {
    let sources = Sources::open(paths, &choice.mappings).unwrap();
    let chosen = sources.choose(choice).unwrap();
    let t0 = std::time::Instant::now();
    let a = understand(chosen.wheels, &chosen.poses, hints, chosen.same_clock).unwrap();
    println!("understand {:?}", t0.elapsed());
    a
}

/// The speed growth that `explain` finds in a folder, and its standard error.
fn speed_growth(folder: &Path) -> (f64, f64) {
    let (read, recordings) = Campaign::read_both(folder).unwrap();
    let model = recordings.into_model(&read, folder).unwrap();
    let answer = explain(&model).unwrap();
    let effects: Vec<&str> =
        answer.steps.iter().filter(|step| step.matters).map(|step| step.effect.as_str()).collect();
    assert_eq!(effects, ["speed_growth"]);
    let found = &answer.steps[0].parameters[0];
    (found.value, found.sigma)
}

fn check(understood: &Understood) {
    let t0 = std::time::Instant::now();
    for run in &understood.runs {
        println!(
            "{:>8.2} s  {:<20} {:>6.2} s",
            run.started_s - understood.runs[0].started_s,
            run.name,
            run.recording.duration_s()
        );
    }
    println!("{:?} {:?} {:?}", understood.clock, understood.left_out, understood.notes);
    println!("{:?}", understood.robot);
    let off_s = understood.clock.late_s - LATE_S;
    assert!(off_s.abs() < 0.002, "the clock is off by {:.4} s", off_s);
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("my-robot");
    let names = write(understood, &folder, false).unwrap();
    assert_eq!(names.len(), understood.runs.len());
    println!("write {:?}", t0.elapsed());
    let (value, _) = speed_growth(&folder);
    println!("explain {:?}", t0.elapsed());
    let (expected, sigma) = speed_growth(Path::new(MYSTERY));
    println!("{value} {expected} {sigma}");
    assert!((value - expected).abs() < sigma, "{value}, and without a detour {expected} ± {sigma}");
}

#[test]
fn a_bag_with_the_tracker_in_its_own_frame_and_clock_gives_the_same_verdict() {
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("drive.mcap");
    let log = OneLog::of(Path::new(MYSTERY), LATE_S);
    std::fs::write(&bag, log.bag()).unwrap();
    let hints = Hints::default();
    check(&imported(&[bag], &Choice::default(), &hints));
}

#[test]
fn a_table_and_a_trajectory_give_the_same_verdict_and_nobody_need_know_the_clocks() {
    let folder = tempfile::tempdir().unwrap();
    let (table, track) = (folder.path().join("wheels.csv"), folder.path().join("track.tum"));
    let log = OneLog::of(Path::new(MYSTERY), LATE_S);
    std::fs::write(&table, log.table()).unwrap();
    std::fs::write(&track, log.trajectory()).unwrap();
    let mappings = parse_mappings("left_counts=enc_l,right_counts=enc_r,t_s=stamp:ns").unwrap();
    let choice = Choice { mappings, ..Choice::default() };
    let hints = Hints {
        wheel_radius_m: Some(0.036),
        track_width_m: Some(0.372),
        counts_per_rev: Some(900.0),
        ..Hints::default()
    };
    check(&imported(&[table, track], &choice, &hints));
}
