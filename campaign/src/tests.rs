use std::fs;
use std::path::Path;

use proptest::prelude::*;
use shared_proto::WheelPair;

use super::*;

mod wrong_files;

fn robot() -> RobotFile {
    RobotFile {
        name: "Biene \"Maja\"".into(),
        wheel_radius_m: 0.036,
        track_width_m: 0.372,
        counts_per_rev: 900.0,
        gear_reduction: 1.0,
        position_sigma_m: Some(0.001),
        heading_sigma_rad: None,
        supply_v: Some(12.0),
        uid: None,
        simulated: None,
        runs: Vec::new(),
    }
}

fn row(i: u32) -> Row {
    let t_s = f64::from(i) * 0.02;
    let seen = i.is_multiple_of(3);
    Row {
        t_s,
        counts: WheelPair::new(Some(f64::from(i) * 7.0), Some(f64::from(i) * -6.5)),
        x_m: seen.then_some(t_s * 0.1),
        y_m: seen.then_some(t_s * 0.2),
        heading_rad: seen.then_some(-0.001),
        ..Row::default()
    }
}

fn record(folder: &Path, name: &str, facts: RunFacts) -> std::path::PathBuf {
    let writer = CampaignWriter::open(folder, &robot()).unwrap();
    let mut run = writer.start_run(name, &[Column::X, Column::Y, Column::Heading]).unwrap();
    (0..10).for_each(|i| run.push(&row(i)).unwrap());
    run.finish(facts).unwrap()
}

/// The error of reading a campaign with these files.
fn error(toml: &str, csv: Option<&str>) -> String {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("runs")).unwrap();
    fs::write(folder.path().join("robot.toml"), toml).unwrap();
    if let Some(csv) = csv {
        fs::write(folder.path().join("runs/01_a.csv"), csv).unwrap();
    }
    let error = Campaign::read(folder.path()).unwrap_err().to_string();
    error.replace(&folder.path().display().to_string(), "ROBOT")
}

const TOML: &str =
    "name = \"r\"\nwheel_radius_m = 0.036\ntrack_width_m = 0.372\ncounts_per_rev = 900\n";
const CSV: &str = "t_s,left_counts,right_counts\n0,0,0\n1,5,5\n";

#[test]
fn what_is_written_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let facts = RunFacts {
        started_s: Some(1800.0),
        payload_kg: Some(2.5),
        held_out: true,
        ..RunFacts::default()
    };
    record(folder.path(), "straight", facts.clone());
    let campaign = Campaign::read(folder.path()).unwrap();
    assert_eq!(campaign.runs[0].name, "01_straight");
    assert_eq!(campaign.runs[0].facts, RunFacts { name: "01_straight".into(), ..facts });
    assert_eq!(campaign.runs[0].rows, (0..10).map(row).collect::<Vec<_>>());
    assert!(campaign.warnings.is_empty());
    assert_eq!(RobotFile { runs: Vec::new(), ..campaign.robot }, robot());
}

#[test]
fn the_same_run_gives_the_same_bytes() {
    let bytes = [(); 2].map(|()| {
        let folder = tempfile::tempdir().unwrap();
        let csv = fs::read(record(folder.path(), "a", RunFacts::default())).unwrap();
        (csv, fs::read(folder.path().join("robot.toml")).unwrap())
    });
    assert_eq!(bytes[0], bytes[1]);
    let text = String::from_utf8(bytes[0].0.clone()).unwrap();
    assert!(text.starts_with(
        "t_s,left_counts,right_counts,x_m,y_m,heading_rad\n\
         0.000000,0,0,0.0000000,0.0000000,-0.0010000\n0.020000,7,-6.5,,,\n"
    ));
}

#[test]
fn no_run_is_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let names: Vec<_> = (0..3)
        .map(|_| record(folder.path(), "a", RunFacts::default()))
        .map(|path| path.file_name().unwrap().to_str().unwrap().to_owned())
        .collect();
    assert_eq!(names, ["01_a.csv", "02_a.csv", "03_a.csv"]);
}

/// Somebody removed a run and left what `robot.toml` says of it: the next one does not get its number, and so not its facts.
#[test]
fn the_number_of_a_run_that_was_removed_is_not_given_again() {
    let folder = tempfile::tempdir().unwrap();
    let facts = || RunFacts { payload_kg: Some(2.5), ..RunFacts::default() };
    record(folder.path(), "a", facts());
    fs::remove_file(record(folder.path(), "a", facts())).unwrap();
    let names = |paths: Vec<std::path::PathBuf>| -> Vec<String> {
        paths.iter().map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names(vec![record(folder.path(), "a", facts())]), ["03_a"]);
    // Nor where many are announced at once; all of them have their facts, and none stays announced.
    let writer = CampaignWriter::open(folder.path(), &robot()).unwrap();
    let announced = ["b", "c"].map(|name| RunFacts { name: name.into(), ..facts() });
    let mut announced = announced_runs::AnnouncedRuns::new(&writer, announced.into()).unwrap();
    for name in ["b", "c"] {
        let mut run = writer.draft_run(name, &[]);
        (0..10).for_each(|i| run.push(&row(i)).unwrap());
        announced.write(&run).unwrap();
    }
    assert_eq!(names(announced.finish().unwrap()), ["04_b", "05_c"]);
    let toml = RobotFile::read(&folder.path().join("robot.toml")).unwrap();
    let told: Vec<&str> = toml.runs.iter().map(|run| run.name.as_str()).collect();
    assert_eq!(told, ["01_a", "02_a", "03_a", "04_b", "05_c"]);
    assert!(toml.runs.iter().all(|run| run.payload_kg == Some(2.5) && !run.pending));
}

#[test]
fn an_abandoned_run_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let writer = CampaignWriter::open(folder.path(), &robot()).unwrap();
    let mut run = writer.start_run("a", &[]).unwrap();
    run.push(&row(0)).unwrap();
    // Not even while it is written: a program that is killed cannot remove anything.
    assert_eq!(fs::read_dir(folder.path().join("runs")).unwrap().count(), 0);
    drop(run);
    assert!(!folder.path().join("runs").exists());
}

#[test]
fn comments_in_robot_toml_survive_a_new_run() {
    let folder = tempfile::tempdir().unwrap();
    let toml = folder.path().join("robot.toml");
    fs::write(&toml, format!("# my robot\n{TOML}supply_v = 12 # fresh\n")).unwrap();
    let facts = RunFacts { started_s: Some(5.0), ..RunFacts::default() };
    record(folder.path(), "a", facts);
    let text = fs::read_to_string(&toml).unwrap();
    assert!(text.starts_with("# my robot\n") && text.contains("# fresh"), "{text}");
    assert_eq!(Campaign::read(folder.path()).unwrap().runs[0].facts.started_s, Some(5.0));
}

#[test]
fn another_robots_campaign_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), "a", RunFacts::default());
    for (other, expected) in [
        (RobotFile { track_width_m: 0.42, ..robot() }, "track_width_m = 0.372 is of another robot"),
        (
            RobotFile { wheel_radius_m: 0.03, ..robot() },
            "wheel_radius_m = 0.036 is of another robot",
        ),
        (RobotFile { counts_per_rev: 901.0, ..robot() }, "counts_per_rev = 900 is of another"),
    ] {
        let error = CampaignWriter::open(folder.path(), &other).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn a_robot_that_was_calibrated_goes_on_with_its_campaign_whose_nominal_stays() {
    let folder = tempfile::tempdir().unwrap();
    record(folder.path(), "a", RunFacts::default());
    let before = fs::read(folder.path().join("robot.toml")).unwrap();
    let calibrated = RobotFile { wheel_radius_m: 0.03618, track_width_m: 0.376, ..robot() };
    CampaignWriter::open(folder.path(), &calibrated).unwrap();
    assert_eq!(fs::read(folder.path().join("robot.toml")).unwrap(), before);
}

#[test]
fn robots_of_the_same_kind_are_told_apart_by_their_uids_where_both_have_one() {
    let folder = tempfile::tempdir().unwrap();
    let with = |uid: &str| RobotFile { uid: Some(uid.into()), ..robot() };
    CampaignWriter::open(folder.path(), &with("0a")).unwrap();
    CampaignWriter::open(folder.path(), &RobotFile { name: "renamed".into(), ..with("0a") })
        .unwrap();
    CampaignWriter::open(folder.path(), &robot()).unwrap();
    let error = CampaignWriter::open(folder.path(), &with("0b")).unwrap_err().to_string();
    assert!(error.contains("uid = 0a is of another robot: this one has 0b"), "{error}");
}

#[test]
fn a_robot_toml_that_facts_would_spoil_is_refused_before_a_run_and_left_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let toml = folder.path().join("robot.toml");
    let text = format!("{TOML}run = []\n");
    fs::write(&toml, &text).unwrap();
    let error = CampaignWriter::open(folder.path(), &robot()).unwrap_err().to_string();
    assert!(error.contains("cannot be added") && error.contains("[[run]] sections"), "{error}");
    assert_eq!(fs::read_to_string(&toml).unwrap(), text);
}

#[test]
fn a_run_whose_facts_cannot_be_written_is_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let writer = CampaignWriter::open(folder.path(), &robot()).unwrap();
    let mut run = writer.start_run("a", &[]).unwrap();
    (0..10).for_each(|i| run.push(&row(i)).unwrap());
    // Somebody edits the file meanwhile.
    fs::write(folder.path().join("robot.toml"), format!("{TOML}run = []\n")).unwrap();
    let facts = RunFacts { payload_kg: Some(2.0), ..RunFacts::default() };
    let error = run.finish(facts).unwrap_err().to_string();
    assert!(error.contains("cannot be added"), "{error}");
    assert!(!folder.path().join("runs").exists());
}

#[test]
fn headings_alone_are_no_poses_and_runs_without_positions_are_named() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("runs")).unwrap();
    fs::write(folder.path().join("robot.toml"), TOML).unwrap();
    let write = |name: &str, rows: &str| {
        let text = format!("t_s,left_counts,right_counts,x_m,y_m,heading_rad\n{rows}");
        fs::write(folder.path().join("runs").join(name), text).unwrap();
    };
    write("01_spin.csv", "0,0,0,,,0\n1,5,5,,,0.1\n2,9,9,,,0.2\n");
    let read = || Campaign::read(folder.path()).unwrap();
    let error = read().to_model(folder.path()).unwrap_err().to_string();
    assert!(error.contains("headings alone are not enough; fill in x_m"), "{error}");
    // Nothing was measured after the one position.
    write("02_once.csv", "0,0,0,,,0\n1,5,5,,,0.1\n2,9,9,0,0,0.2\n");
    assert!(read().to_model(folder.path()).is_err());
    write("03_seen.csv", "0,0,0,0,0,\n1,5,5,,,0.1\n2,9,9,,,0.2\n");
    assert!(read().to_model(folder.path()).is_ok());
    assert_eq!(read().without_poses(), ["01_spin", "02_once"]);
}

#[test]
fn samples_that_could_not_be_read_again_are_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let writer = CampaignWriter::open(folder.path(), &robot()).unwrap();
    let mut run = writer.start_run("a", &[Column::X]).unwrap();
    run.push(&row(1)).unwrap();
    let again = run.push(&Row { t_s: 0.020_000_4, ..row(1) }).unwrap_err().to_string();
    assert!(again.contains("the time goes from 0.02 s to 0.02 s"), "{again}");
    let nan = run.push(&Row { x_m: Some(f64::NAN), ..row(2) }).unwrap_err().to_string();
    assert!(nan.contains("line 3, column 4: x_m is NaN"), "{nan}");
    let short = run.finish(RunFacts::default()).unwrap_err().to_string();
    assert!(short.contains("at least two samples"), "{short}");
    assert!(writer.start_run("../a", &[]).is_err());
    assert!(writer.start_run(&"a".repeat(100), &[]).is_ok());
    let error = writer.start_run(&"a".repeat(101), &[]).unwrap_err().to_string();
    assert!(error.contains("101 characters"), "{error}");
}

#[test]
fn unknown_columns_are_named_and_ignored() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.csv");
    fs::write(&file, "t_s, colour ,right_counts,left_counts\n0,red,1,2\n1,,3,4\n").unwrap();
    let (rows, warnings) = read_run(&file).unwrap();
    assert_eq!(rows[1].counts, WheelPair::new(Some(4.0), Some(3.0)));
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].to_string().contains("line 1, column 2: the column `colour`"));
}

#[test]
fn what_the_model_sees_is_what_was_recorded() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("runs")).unwrap();
    fs::write(folder.path().join("robot.toml"), format!("{TOML}{FACTS}")).unwrap();
    fs::write(folder.path().join("runs/01_a.csv"), POSES).unwrap();
    let campaign = Campaign::read(folder.path()).unwrap().to_model(folder.path()).unwrap();
    let run = &campaign.runs[0];
    assert_eq!((run.started_s, run.payload_kg), (Some(5.0), 2.5));
    // A row without counts is a camera sample alone; one without a heading still has its position.
    assert_eq!((run.wheels.len(), run.measured_poses.len(), run.gyro.len()), (3, 4, 3));
    assert_eq!(run.measured_poses[2].heading_rad, None);
    let full_turn = std::f64::consts::TAU;
    assert!((run.wheels[2].phi_rad.right - full_turn * 15.0 / 900.0).abs() < 1e-15);
}

/// A campaign with one run for each of these facts, which stand in its `robot.toml`; each run has
/// poses.
fn with_facts(facts: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("runs")).unwrap();
    let mut toml = TOML.to_owned();
    for (k, facts) in facts.iter().enumerate() {
        let file = folder.path().join(format!("runs/{k}.csv"));
        // No copies of one another.
        fs::write(file, POSES.replace("15,15", &format!("15,{}", 15 + k))).unwrap();
        toml += &format!("[[run]]\nname = \"{k}\"\n{facts}\n");
    }
    fs::write(folder.path().join("robot.toml"), toml).unwrap();
    folder
}

#[test]
fn runs_held_out_reach_the_model_marked_and_one_at_least_is_to_be_fitted_to() {
    let folder = with_facts(&["held_out = true", "payload_kg = 1", "held_out = false"]);
    let campaign = Campaign::read(folder.path()).unwrap().to_model(folder.path()).unwrap();
    let held_out: Vec<_> = campaign.runs.iter().map(|run| run.held_out).collect();
    assert_eq!(held_out, [true, false, false]);
    for (facts, expected) in [
        (&["held_out = true"][..], "robot.toml: the only run is held out, so none is left"),
        (
            &["held_out = true"; 3],
            "robot.toml: all 3 runs are held out, so none is left to fit; remove",
        ),
    ] {
        let folder = with_facts(facts);
        let error = Campaign::read(folder.path()).unwrap().to_model(folder.path()).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
    let folder = with_facts(&["held_out = 1"]);
    let error = Campaign::read(folder.path()).unwrap_err().to_string();
    assert!(
        error.contains("line 7, column 12: invalid type: integer `1`, expected a boolean"),
        "{error}"
    );
}

#[test]
fn runs_without_a_start_time_are_reported_once_if_that_hides_drift() {
    for (facts, expected) in [
        (&["", ""][..], Some("started_s is missing for all 2 runs")),
        (&["started_s = 0", "", "payload_kg = 1"], Some("started_s is missing for 2 of 3 runs")),
        (&["started_s = 0", "started_s = 60"], None),
        // A single run shows no drift, and nothing is fitted to one that is held out.
        (&[""], None),
        (&["started_s = 0", "held_out = true", "started_s = 9"], None),
    ] {
        let warnings = Campaign::read(with_facts(facts).path()).unwrap().warnings;
        let said: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        assert_eq!(said.len(), usize::from(expected.is_some()), "{said:?}");
        assert!(expected.is_none_or(|expected| said[0].contains(expected)), "{said:?}");
        for warning in &said {
            assert!(warning.contains("thermal_drift") && warning.contains("add started_s"));
        }
    }
}

/// A file with a piece cut out and replaced by another.
fn mangled(text: &str, cut: usize, length: usize, put: &str) -> String {
    let mut text: Vec<char> = text.chars().collect();
    let from = cut.min(text.len());
    let to = (from + length).min(text.len());
    text.splice(from..to, put.chars());
    text.into_iter().collect()
}

/// A campaign is either read and converted, or refused with a hint.
fn read_or_refused(toml: &str, csv: &[u8]) -> Result<(), TestCaseError> {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("runs")).unwrap();
    fs::write(folder.path().join("robot.toml"), toml).unwrap();
    fs::write(folder.path().join("runs/01_a.csv"), csv).unwrap();
    let model = Campaign::read(folder.path()).and_then(|campaign| campaign.to_model(folder.path()));
    if let Err(error) = model {
        prop_assert!(!error.hint.is_empty() && !error.problem.is_empty(), "{error:?}");
    }
    Ok(())
}

const POSES: &str = "t_s,left_counts,right_counts,x_m,y_m,heading_rad,gyro_z_rad_s\n\
                     0,0,0,0,0,0,0.1\n0.1,5,5,0.01,0,0,\n0.2,,,0.02,0,,0.2\n0.3,15,15,0.03,0,0,0.1\n";
const FACTS: &str = "\n[[run]]\nname = \"01_a\"\nstarted_s = 5\npayload_kg = 2.5\n";

proptest! {
    #[test]
    fn mangled_runs_are_refused_or_read_but_never_panic(
        cut in 0_usize..160, length in 0_usize..30, put in "[0-9eE.,\n\"+-]{0,10}|nan|inf|1e308|\u{feff}",
    ) {
        read_or_refused(TOML, mangled(POSES, cut, length, &put).as_bytes())?;
    }

    #[test]
    fn mangled_robots_are_refused_or_read_but_never_panic(
        cut in 0_usize..160, length in 0_usize..30, put in "[ -~\n]{0,10}|nan|inf|1e308|1e-308",
    ) {
        read_or_refused(&mangled(&format!("{TOML}{FACTS}"), cut, length, &put), POSES.as_bytes())?;
    }

    #[test]
    fn any_bytes_are_refused_or_read_but_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        read_or_refused(TOML, &bytes)?;
    }
}
